//! Tests of the containers of recordings through their public interface.

mod captures;
mod final_format;
mod forge;
mod gps;
mod hexadecimal;
mod packets;
mod properties;
mod recordings;
mod sections;
