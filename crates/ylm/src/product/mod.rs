//! Products of SH functions.

pub mod grid;
#[cfg(test)]
mod oracle;
