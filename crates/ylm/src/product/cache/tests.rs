use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;

/// Whether `get` gives four threads at once the very same table.
pub fn same_from_every_thread<Table: Send + Sync>(get: impl Fn() -> Arc<Table> + Sync) -> bool {
    let tables: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(&get)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    tables.iter().all(|table| Arc::ptr_eq(table, &tables[0]))
}

struct Square(usize);

#[test]
fn a_table_is_built_once_however_many_threads_ask() {
    let builds = AtomicUsize::new(0);
    let ask = |size: usize| {
        shared((size, 0), || {
            builds.fetch_add(1, Ordering::Relaxed);
            Square(size * size)
        })
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|i| scope.spawn(move || (i % 2, ask(i % 2)))).collect();
        for thread in threads {
            let (size, table) = thread.join().unwrap();
            assert_eq!(table.0, size * size);
            assert!(Arc::ptr_eq(&table, &ask(size)));
        }
    });
    assert_eq!(builds.into_inner(), 2);
}

#[test]
fn one_table_may_be_built_of_another() {
    let outer = shared((3, 1), || Square(shared((2, 1), || Square(2)).0 + 1));
    assert_eq!(outer.0, 3);
}
