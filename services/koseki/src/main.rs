//! koseki
fn main() {}
