//! Columns of the tables of `koseki locate`, for the tables and for the help.

/// Columns of the table of fixes.
pub(crate) const FIX_COLUMNS: &str =
    "time_s,emitter_id,x,y,z,vx,vy,vz,variance_m2,stage,selected,raw_x,raw_y,Pxx,Pxy,Pyy,raw_vx,raw_vy,motion,agreed";

/// Columns behind them, if the origin of the plane is known.
pub(crate) const PLACE_COLUMNS: &str = ",latitude,longitude";

/// Columns of the table of decisions.
pub(crate) const DECISION_COLUMNS: &str = "time_s,emitter_id,decision,subject,reason,value,limit";
