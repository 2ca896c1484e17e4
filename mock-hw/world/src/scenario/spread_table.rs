//! `[participant.spread]`: ranges from which a person's contact with the plate is drawn.

use super::ranges::drawable;

drawable! {
    /// Ranges, given by both ends, from which the constants of a person's skin are drawn; a constant without a range is taken
    /// from `[film]`, `[friction]` or `[participant.moisture]`.
    ///
    /// Areas, q0, moduli and times are drawn on a logarithmic scale. Ranges of a scenario are assumptions: the area grows with
    /// the force by a smaller exponent than Hertz's 2/3 (Adams et al. 2013, J. R. Soc. Interface 10), and differs between
    /// people, as finger pads do.
    SpreadTable => PersonDrawn, "participant.spread";
    /// Apparent contact area S at 1 N, m².
    contact_area_m2: log, 10e-6, 1e-3, "m²";
    /// Exponent of the normal force in the contact area.
    area_force_exponent: linear, 0.0, 0.7, "";
    /// Roughness cut-off q0, rad/m.
    q0_rad_per_m: log, 1e3, 1e6, "rad/m";
    /// Young's modulus E, Pa.
    youngs_modulus_pa: log, 1e5, 1e9, "Pa";
    /// Loss factor η of the contact.
    loss_factor: linear, 0.0, 1.0, "";
    /// Time constant of levitation at a gap of 10 µm, s.
    lag_s: log, 2e-4, 0.1, "s";
    /// Exponent of the gap in the time constant of levitation.
    lag_gap_exponent: linear, -1.0, 1.0, "";
    /// Share of friction that levitation does not reduce.
    floor: linear, 0.0, 0.9, "";
    /// Exponent of the sliding speed in friction.
    speed_exponent: linear, -0.5, 0.5, "";
    /// Relative growth of friction while the finger touches.
    ageing: linear, -0.5, 5.0, "";
    /// Time constant of the growth of friction, s.
    ageing_time_s: log, 0.1, 1e3, "s";
    /// Relative growth of σ_t and Im Z_t while the finger touches.
    growth: linear, -0.5, 1.0, "";
}
