//! The virtual participant follows the screen like a person: with delay, imprecisely, and learning.

use mock_world::person::{Act, HeardCue, PerceivedInstruction, Percept, VirtualPerson};
use mock_world::scenario::{BehaviourTable, ParticipantTable};

const DT_S: f64 = 2e-3;
const START_M: f64 = 0.01;
const END_M: f64 = 0.095;
const SPEED_M_PER_S: f64 = 0.05;

/// A person at a screen.
struct Session {
    person: VirtualPerson,
    t_s: f64,
}

impl Session {
    fn new(behaviour: BehaviourTable, seed: u64) -> Self {
        let participant = ParticipantTable {
            behaviour,
            ..ParticipantTable::default()
        };
        Self {
            person: VirtualPerson::draw(&participant, seed),
            t_s: 0.0,
        }
    }

    fn watch(&mut self, seconds: f64, percept: impl Fn(f64) -> Percept) -> Vec<Act> {
        let steps = (seconds / DT_S).round() as usize;
        (0..steps)
            .map(|i| {
                let act = self.person.step(self.t_s, DT_S, &percept(i as f64 * DT_S));
                self.t_s += DT_S;
                act
            })
            .collect()
    }

    fn follow(&mut self, seconds: f64, instruction: PerceivedInstruction) -> Vec<Act> {
        self.watch(seconds, |_| Percept {
            instruction,
            ..Percept::default()
        })
    }

    /// Places the finger, waits for the button, counts down; returns the time of the button press, s.
    fn get_ready(&mut self) -> Option<f64> {
        let acts = self.watch(4.0, |_| mark(PerceivedInstruction::PlaceFinger));
        self.watch(1.0, |_| mark(PerceivedInstruction::GetReady));
        acts.iter()
            .position(|a| a.button_pressed)
            .map(|i| i as f64 * DT_S)
    }

    /// Explores once from left to right; returns the acts.
    fn explore(&mut self) -> Vec<Act> {
        let seconds = (END_M - START_M) / SPEED_M_PER_S;
        self.watch(seconds, |t| Percept {
            instruction: PerceivedInstruction::FollowSlider,
            slider_m: Some(START_M + SPEED_M_PER_S * t),
            ..Percept::default()
        })
    }
}

fn mark(instruction: PerceivedInstruction) -> Percept {
    Percept {
        instruction,
        slider_m: Some(START_M),
        force_band_n: Some((0.5, 0.8)),
        ..Percept::default()
    }
}

/// A person without lapses.
fn attentive() -> BehaviourTable {
    BehaviourTable {
        late_start_probability: 0.0,
        lift_off_probability: 0.0,
        ..BehaviourTable::default()
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    sum / n
}

/// Returns the acts within the central 60 mm.
fn central(acts: &[Act]) -> impl Iterator<Item = &Act> {
    acts.iter()
        .filter(|a| (0.0225..=0.0825).contains(&a.finger.position_m))
}

#[test]
fn no_person_touches_the_plate_before_the_instruction() {
    let mut session = Session::new(attentive(), 1);
    for instruction in [
        PerceivedInstruction::Wait,
        PerceivedInstruction::LiftFinger,
        PerceivedInstruction::Rest,
    ] {
        let acts = session.follow(1.0, instruction);
        assert!(acts.iter().all(|a| !a.finger.touching && !a.button_pressed));
    }
}

#[test]
fn places_the_finger_on_the_mark_then_presses_the_button() {
    for seed in 0..20 {
        let mut session = Session::new(attentive(), seed);
        let pressed_s = session.get_ready().unwrap();
        assert!(
            (0.5..2.5).contains(&pressed_s),
            "seed {seed}: {pressed_s} s"
        );
        let now = session.watch(0.1, |_| mark(PerceivedInstruction::GetReady))[0].finger;
        assert!(
            now.touching && (now.position_m - START_M).abs() < 2e-3,
            "{now:?}"
        );
    }
}

#[test]
fn presses_the_button_to_go_on_and_again_if_nothing_happens() {
    let mut session = Session::new(attentive(), 1);
    let acts = session.follow(6.0, PerceivedInstruction::PressButton);
    assert!(acts.iter().all(|a| !a.finger.touching));
    let presses = acts
        .windows(2)
        .filter(|w| w[1].button_pressed && !w[0].button_pressed)
        .count();
    assert!((2..=3).contains(&presses), "{presses}");
}

#[test]
fn follows_the_slider_at_its_speed_over_the_central_60_mm() {
    let mut averages = Vec::new();
    for seed in 0..20 {
        let mut session = Session::new(attentive(), seed);
        session.get_ready();
        let acts = session.explore();
        let first_motion_s = acts
            .iter()
            .position(|a| a.finger.velocity_m_per_s > 0.02)
            .unwrap() as f64
            * DT_S;
        assert!((0.15..0.8).contains(&first_motion_s), "{first_motion_s} s");
        let speeds: Vec<f64> = central(&acts).map(|a| a.finger.velocity_m_per_s).collect();
        assert!(
            speeds.len() as f64 * DT_S > 0.9,
            "seed {seed}: {} samples",
            speeds.len()
        );
        let count = speeds
            .iter()
            .filter(|v| (**v / SPEED_M_PER_S - 1.0).abs() < 0.2)
            .count();
        assert!(
            count as f64 > 0.75 * speeds.len() as f64,
            "seed {seed}: {count} of {}",
            speeds.len()
        );
        averages.push(mean(speeds.iter().copied()) / SPEED_M_PER_S);
        assert!(central(&acts).all(|a| a.finger.touching));
    }
    // A finger that has started lags behind the slider and catches up, so people are slightly fast.
    let overall = mean(averages.iter().copied());
    assert!((1.0..1.07).contains(&overall), "{overall}");
    assert!(
        averages.iter().all(|a| (a - 1.0).abs() < 0.15),
        "{averages:?}"
    );
}

#[test]
fn velocity_is_the_derivative_of_position() {
    let mut session = Session::new(attentive(), 3);
    session.get_ready();
    let acts = session.explore();
    for pair in acts.windows(51) {
        let travel_m = pair[50].finger.position_m - pair[0].finger.position_m;
        let integral_m: f64 = pair[1..]
            .iter()
            .map(|a| a.finger.velocity_m_per_s * DT_S)
            .sum();
        assert!(
            (travel_m - integral_m).abs() < 0.1e-3,
            "{travel_m} {integral_m}"
        );
    }
}

#[test]
fn learns_the_force_from_the_mean_that_is_shown() {
    let people: u32 = 30;
    let (mut first, mut fourth) = (0.0, 0.0);
    for seed in 0..people {
        let behaviour = BehaviourTable {
            force_misjudgement: 0.4,
            ..attentive()
        };
        let mut session = Session::new(behaviour, seed.into());
        for trial in 0..4 {
            session.get_ready();
            let acts = session.explore();
            let mean_n = mean(central(&acts).map(|a| a.finger.normal_n));
            let error = (mean_n - 0.65).abs() / f64::from(people);
            match trial {
                0 => first += error,
                3 => fourth += error,
                _ => {}
            }
            session.watch(1.0, |_| Percept {
                instruction: PerceivedInstruction::Feedback,
                mean_force_n: Some(mean_n),
                force_band_n: Some((0.5, 0.8)),
                ..Percept::default()
            });
        }
    }
    assert!(first > 0.1, "{first}");
    assert!(fourth < 0.03, "{fourth}");
}

#[test]
fn force_is_never_quite_still_and_mostly_in_the_band() {
    let mut session = Session::new(attentive(), 5);
    session.get_ready();
    let forces: Vec<f64> = session
        .watch(20.0, |_| mark(PerceivedInstruction::GetReady))
        .iter()
        .map(|a| a.finger.normal_n)
        .collect();
    let average = mean(forces.iter().copied());
    let sd = mean(forces.iter().map(|f| (f - average).powi(2))).sqrt();
    assert!((0.015..0.06).contains(&sd), "{sd}");
    assert!(
        forces.windows(2).all(|w| (w[1] - w[0]).abs() < 0.01),
        "force jumps"
    );
}

#[test]
fn hears_the_end_and_lifts() {
    let mut session = Session::new(attentive(), 2);
    session.get_ready();
    session.explore();
    let end = Percept {
        instruction: PerceivedInstruction::FollowSlider,
        slider_m: Some(END_M),
        cue: Some(HeardCue::End),
        ..Percept::default()
    };
    session.watch(DT_S, |_| end);
    // The screen may lag behind the sound.
    session.watch(10.0 * DT_S, |_| Percept { cue: None, ..end });
    let acts = session.follow(1.5, PerceivedInstruction::LiftFinger);
    assert!(
        acts[20].finger.touching,
        "lifts sooner than anyone could react"
    );
    assert!(!acts[acts.len() - 1].finger.touching);
}

#[test]
fn lapses_come_as_often_as_the_scenario_says() {
    let acts = |behaviour: &BehaviourTable, seed| {
        let mut session = Session::new(behaviour.clone(), seed);
        session.get_ready();
        session.explore()
    };
    let late_starts = BehaviourTable {
        late_start_probability: 0.3,
        late_start_s: 1.0,
        ..attentive()
    };
    let lift_offs = BehaviourTable {
        lift_off_probability: 0.3,
        ..attentive()
    };
    let is_late = |seed: &u64| {
        acts(&late_starts, *seed)[..450]
            .iter()
            .all(|a| a.finger.velocity_m_per_s < 0.02)
    };
    let has_lifted = |seed: &u64| acts(&lift_offs, *seed).iter().any(|a| !a.finger.touching);
    let late_count = (0..100).filter(is_late).count();
    let lifted_count = (0..100).filter(has_lifted).count();
    // Three standard deviations of a binomial of 100 at 0.3.
    assert!((16..=44).contains(&late_count), "{late_count}");
    assert!((16..=44).contains(&lifted_count), "{lifted_count}");
}

#[test]
fn the_same_seed_is_the_same_person() {
    let acts = |seed| {
        let mut session = Session::new(BehaviourTable::default(), seed);
        session.get_ready();
        session.explore()
    };
    assert_eq!(acts(4), acts(4));
    assert_ne!(acts(4), acts(5));
}
