//! The bake: light-independent transfer of every lighting point.
