//! Scorers from outside: small cases worked out on paper, and pictures of known quality.

mod by_hand;
mod picture;
