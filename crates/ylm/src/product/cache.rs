//! Tables built on first use and shared by every thread.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

type Key = (TypeId, usize, usize);
type Shared = Arc<dyn Any + Send + Sync>;

/// The table of a type and two sizes, built at the first call and kept until the process ends.
///
/// Threads that ask for a table that is being built wait for it; those that ask for another one do not.
pub fn shared<Table: Any + Send + Sync>(sizes: (usize, usize), build: impl FnOnce() -> Table) -> Arc<Table> {
    static TABLES: OnceLock<Mutex<HashMap<Key, Arc<OnceLock<Shared>>>>> = OnceLock::new();
    let entry = {
        // A panic elsewhere leaves the map whole: it is only ever added to.
        let mut tables = TABLES.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(tables.entry((TypeId::of::<Table>(), sizes.0, sizes.1)).or_default())
    };
    let table = Arc::clone(entry.get_or_init(|| Arc::new(build())));
    table.downcast().expect("the key names the type")
}

#[cfg(test)]
pub mod tests;
