//! What an object is made of.

use std::sync::OnceLock;

use ylm::Bands;

use crate::error::Result;
use crate::scene::brdf::Brdf;
use crate::shade::BrdfTable;

/// A BRDF, and its table once it is needed.
pub struct Material {
    /// How it reflects.
    pub brdf: Brdf,
    table: OnceLock<BrdfTable>,
}

impl Material {
    /// Of a BRDF; nothing is tabulated yet.
    pub fn new(brdf: Brdf) -> Self {
        Self { brdf, table: OnceLock::new() }
    }

    /// The table, made at the first call.
    ///
    /// # Errors
    /// If memory does not suffice.
    ///
    /// # Panics
    /// If it was made in other bands before.
    pub fn table(&self, bands: Bands) -> Result<&BrdfTable> {
        let table = match self.table.get() {
            Some(table) => table,
            None => {
                let made = BrdfTable::new(&self.brdf, bands)?;
                self.table.get_or_init(|| made)
            }
        };
        assert_eq!(table.bands(), bands, "a material has one number of bands");
        Ok(table)
    }
}

impl std::fmt::Debug for Material {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.brdf.fmt(f)
    }
}
