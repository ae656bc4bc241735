//! Tests of whole recordings through their public interface.

mod belief;
mod forge;
mod recordings;
mod statistics;
