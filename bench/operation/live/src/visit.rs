//! Schedule of a finger that touches the plate now and then while `monitor` runs, shown on the participant's screen.

use protocols::Instruction;
use tui::ScreenView;

/// Time between two visits, s.
const EVERY_S: f64 = 14.0;
/// Times within a visit at which the finger is placed and begins to slide, s.
const PLACED_S: f64 = 4.0;
const SLIDES_S: f64 = 6.0;
/// Speed of the slider, m/s, as published (Huloux 2021, section IV).
const SPEED_M_PER_S: f64 = 0.05;
/// Normal force to keep, N (same source).
const FORCE_N: (f64, f64) = (0.5, 0.8);

/// Returns the view at `now_s` for following a slider on a plate of `plate_m`: there and back, then off the plate.
pub fn visit(now_s: f64, plate_m: f64) -> ScreenView {
    let since_s = now_s.rem_euclid(EVERY_S);
    let (from_m, to_m) = (0.1 * plate_m, 0.9 * plate_m);
    let length_m = to_m - from_m;
    let travel_m = (since_s - SLIDES_S) * SPEED_M_PER_S;
    let (instruction, slider_m) = if since_s < PLACED_S || travel_m > 2.0 * length_m {
        (Instruction::LiftFinger, None)
    } else if travel_m < 0.0 {
        (Instruction::PlaceFinger, Some(from_m))
    } else {
        let back_m = (travel_m - length_m).abs();
        (Instruction::FollowSlider, Some(to_m - back_m))
    };
    ScreenView {
        instruction,
        slider_m,
        plate_m,
        start_m: from_m,
        end_m: to_m,
        force_band_n: Some(FORCE_N),
        ..ScreenView::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finger_comes_slides_there_and_back_and_goes() {
        let view_at = |now_s| visit(now_s, 0.1);
        assert_eq!(view_at(0.0).instruction, Instruction::LiftFinger);
        assert_eq!(view_at(5.0).instruction, Instruction::PlaceFinger);
        let slider_m = |now_s: f64| view_at(now_s).slider_m.unwrap();
        assert!((slider_m(6.0) - 0.01).abs() < 1e-9);
        assert!((slider_m(7.6) - 0.09).abs() < 1e-9);
        assert!((slider_m(8.4) - 0.05).abs() < 1e-9);
        assert_eq!(view_at(13.0).instruction, Instruction::LiftFinger);
        assert_eq!(view_at(14.0 + 5.0), view_at(5.0));
    }
}
