//! Processing of sources as adapters and `koseki track` use it: one program, because linking it costs most.

mod carrying;
mod detection_tracker;
mod emitters;
mod several_sensors;
mod silent_radar;
mod snapshot_intake;
