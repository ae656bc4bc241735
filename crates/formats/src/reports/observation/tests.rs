//! What the items of each category become.
