//! Sensors on board of platforms that move.

mod carried;
mod history;
