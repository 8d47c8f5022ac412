//! Tables built on first use and shared by every thread.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};

/// The table of a type and two sizes, built at the first call.
pub fn shared<Table: Any + Send + Sync>(sizes: (usize, usize), build: impl FnOnce() -> Table) -> Arc<Table> {
    type Key = (TypeId, usize, usize);
    static TABLES: OnceLock<Mutex<HashMap<Key, Arc<dyn Any + Send + Sync>>>> = OnceLock::new();
    let mut tables = match TABLES.get_or_init(Mutex::default).lock() {
        Ok(tables) => tables,
        // A panic elsewhere leaves whole entries: each is inserted complete.
        Err(poisoned) => poisoned.into_inner(),
    };
    let entry = tables.entry((TypeId::of::<Table>(), sizes.0, sizes.1)).or_insert_with(|| Arc::new(build()));
    Arc::clone(entry).downcast().expect("the key names the type")
}
