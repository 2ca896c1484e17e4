//! Numbers of NI-DAQmx, by the names that `NIDAQmx.h` and `constants.py` of NI's Python package give them.

/// `DAQmx_Val_RSE`.
pub(super) const RSE: i32 = 10_083;
/// `DAQmx_Val_NRSE`.
pub(super) const NRSE: i32 = 10_078;
/// `DAQmx_Val_Diff`.
pub(super) const DIFF: i32 = 10_106;
/// `DAQmx_Val_PseudoDiff`.
pub(super) const PSEUDO_DIFF: i32 = 12_529;
/// `DAQmx_Val_Volts`.
pub(super) const VOLTS: i32 = 10_348;
/// `DAQmx_Val_Rising`.
pub(super) const RISING: i32 = 10_280;
/// `DAQmx_Val_ContSamps`.
pub(super) const CONTINUOUS: i32 = 10_123;
/// `DAQmx_Val_DoNotAllowRegen`.
pub(super) const NO_REGENERATION: i32 = 10_158;
/// `DAQmx_Val_GroupByScanNumber`: interleaved.
pub(super) const INTERLEAVED: u32 = 1;
/// `DAQmx_Val_ChanPerLine`.
pub(super) const CHANNEL_PER_LINE: i32 = 0;
/// `DAQmx_Val_X4`: every edge of both signals counts.
pub(super) const X4: i32 = 10_092;
/// `DAQmx_Val_Ticks`.
pub(super) const TICKS: i32 = 10_304;
/// `DAQmx_Val_AHighBHigh`: phase at which an index pulse would count; it is not used.
pub(super) const A_HIGH_B_HIGH: i32 = 10_040;
