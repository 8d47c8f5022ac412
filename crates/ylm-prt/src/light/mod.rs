//! Light from far away: probes, skies, discs, and their SH coefficients.
