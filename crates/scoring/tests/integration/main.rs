//! Tests of the scorers: small cases computed by hand, and pictures of known quality.

mod by_hand;
mod picture;
mod scorecard;
