//! The dead-man switch: the plate is driven only while the switch is held, and only if it was released and pressed
//! since the last drive, so that a contact that is welded, tied down or shorted cannot start a drive.

use serde::Serialize;

/// Next action required of the person at the switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// Release it: it has been closed since before the last drive, or since the start.
    Release,
    /// Press it.
    Press,
    /// No action: it was released, and is held.
    Held,
}

/// Reason for which the switch stops the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LetGo {
    /// The switch was released while the plate was driven.
    Released,
    /// The drive began although the switch was not released and held.
    NotHeld(Hold),
}

/// Time for which the contact must be closed before it counts as held again, ns: a contact bounces, and a loose wire
/// closes for moments.
const STEADY_NS: u64 = 20_000_000;
/// Time for which the contact must be open to prove that it opens, ns.
const OPEN_NS: u64 = 50_000_000;
/// Silence after which a drive counts as over, ns; a modulation passes zero for an instant.
const OVER_NS: u64 = 200_000_000;

/// Progress of the switch, fed with its level; high is closed.
#[derive(Debug)]
pub(crate) struct DeadMan {
    release_ns: u64,
    /// Start of the time for which the contact has not been closed for [`STEADY_NS`], ns; `None` while it is held.
    let_go_ns: Option<u64>,
    /// Start of the uninterrupted time for which it has been closed, and open, ns.
    closed_ns: Option<u64>,
    open_ns: Option<u64>,
    /// Whether it was seen to open since the last drive.
    opened: bool,
    /// Time at which the plate was last driven, ns; `None` after that drive is over.
    driven_ns: Option<u64>,
}

impl DeadMan {
    /// Makes a switch that stops the drive after a release of `release_ns`.
    pub(crate) fn new(release_ns: u64) -> Self {
        Self {
            release_ns,
            let_go_ns: Some(0),
            closed_ns: None,
            open_ns: None,
            opened: false,
            driven_ns: None,
        }
    }

    /// Takes the level, and whether the plate is driven; returns the reason for which it must not be.
    pub(crate) fn poll(&mut self, closed: bool, is_driven: bool, now_ns: u64) -> Option<LetGo> {
        if closed {
            self.open_ns = None;
            let since_ns = *self.closed_ns.get_or_insert(now_ns);
            if now_ns - since_ns >= STEADY_NS {
                self.let_go_ns = None;
            }
        } else {
            self.closed_ns = None;
            self.let_go_ns.get_or_insert(now_ns);
            let since_ns = *self.open_ns.get_or_insert(now_ns);
            self.opened |= self.driven_ns.is_none() && now_ns - since_ns >= OPEN_NS;
        }
        if !is_driven {
            if self
                .driven_ns
                .is_some_and(|last_ns| now_ns - last_ns >= OVER_NS)
            {
                self.driven_ns = None;
                self.opened = false;
            }
            return None;
        }
        let begins = self.driven_ns.replace(now_ns).is_none();
        if begins && self.hold() != Hold::Held {
            return Some(LetGo::NotHeld(self.hold()));
        }
        self.let_go_ns
            .is_some_and(|since_ns| now_ns - since_ns >= self.release_ns)
            .then_some(LetGo::Released)
    }

    /// Returns the next required action.
    pub(crate) fn hold(&self) -> Hold {
        match (self.opened, self.let_go_ns) {
            // Also while it is open, until it has been open for long enough.
            (false, _) => Hold::Release,
            (true, None) => Hold::Held,
            (true, Some(_)) => Hold::Press,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;
    const RELEASE_NS: u64 = 200 * MS;

    /// Switch polled every 2 ms.
    struct Rig {
        switch: DeadMan,
        now_ns: u64,
    }

    impl Rig {
        fn new() -> Self {
            Self {
                switch: DeadMan::new(RELEASE_NS),
                now_ns: 0,
            }
        }

        /// Lets time pass; returns the first stop, and the time to it, ms.
        fn pass(&mut self, ms: u64, closed: bool, is_driven: bool) -> Option<(u64, LetGo)> {
            let mut first = None;
            for step in 1..=ms / 2 {
                self.now_ns += 2 * MS;
                let stop = self.switch.poll(closed, is_driven, self.now_ns);
                first = first.or(stop.map(|why| (2 * step, why)));
            }
            first
        }

        /// Returns a switch that was released and is held.
        fn pressed() -> Self {
            let mut rig = Self::new();
            assert_eq!(rig.pass(100, false, false), None);
            assert_eq!(rig.switch.hold(), Hold::Press);
            assert_eq!(rig.pass(100, true, false), None);
            assert_eq!(rig.switch.hold(), Hold::Held);
            rig
        }
    }

    /// Hazard 15.
    #[test]
    fn a_release_of_a_fifth_of_a_second_stops_and_a_bounce_does_not() {
        let mut rig = Rig::pressed();
        assert_eq!(rig.pass(1000, true, true), None);
        assert_eq!(rig.pass(150, false, true), None);
        assert_eq!(rig.pass(1000, true, true), None, "it was held again");
        let (after_ms, why) = rig.pass(400, false, true).unwrap();
        assert_eq!(why, LetGo::Released);
        assert!((200..=204).contains(&after_ms), "{after_ms} ms");
    }

    /// Hazard 15.
    #[test]
    fn a_switch_that_is_stuck_closed_starts_nothing() {
        let mut stuck = Rig::new();
        stuck.pass(5000, true, false);
        assert_eq!(stuck.switch.hold(), Hold::Release);
        let stop = stuck.pass(2, true, true);
        assert_eq!(stop, Some((2, LetGo::NotHeld(Hold::Release))));
        // A contact that opens for a moment proves nothing.
        let mut bounces = Rig::new();
        bounces.pass(1000, true, false);
        bounces.pass(40, false, false);
        bounces.pass(1000, true, false);
        assert_eq!(bounces.switch.hold(), Hold::Release);
    }

    #[test]
    fn a_person_who_follows_each_request_ends_up_holding_the_switch() {
        // A hand faster than any person's: each poll finds the action that the last one required.
        let mut rig = Rig::new();
        rig.pass(100, true, false);
        let mut holds = Vec::new();
        for _ in 0..200 {
            let hold = rig.switch.hold();
            if holds.last() != Some(&hold) {
                holds.push(hold);
            }
            rig.pass(2, hold != Hold::Release, false);
        }
        assert_eq!(holds, [Hold::Release, Hold::Press, Hold::Held]);
    }

    /// Hazard 15.
    #[test]
    fn each_drive_wants_a_release_and_a_press_of_its_own() {
        let mut rig = Rig::pressed();
        rig.pass(1000, true, true);
        rig.pass(300, true, false);
        assert_eq!(rig.switch.hold(), Hold::Release);
        rig.pass(100, false, false);
        rig.pass(100, true, false);
        assert_eq!(rig.switch.hold(), Hold::Held);
        assert_eq!(rig.pass(1000, true, true), None);
    }

    #[test]
    fn a_modulation_that_passes_zero_is_one_drive() {
        let mut rig = Rig::pressed();
        for _ in 0..20 {
            assert_eq!(rig.pass(160, true, true), None);
            assert_eq!(rig.pass(10, true, false), None);
        }
    }

    proptest! {
        /// Hazard 15.
        #[test]
        fn a_contact_that_never_closes_for_long_stops_in_time_however_it_chatters(
            chatter in prop::collection::vec((1u64..=9, 1u64..=30), 20..60),
        ) {
            let mut rig = Rig::pressed();
            rig.pass(500, true, true);
            let (mut passed_ms, mut stopped_ms) = (0, None);
            for (closed, open) in chatter {
                for (level, steps) in [(false, open), (true, closed)] {
                    if let Some((after_ms, _)) = rig.pass(2 * steps, level, true) {
                        stopped_ms = stopped_ms.or(Some(passed_ms + after_ms));
                    }
                    passed_ms += 2 * steps;
                }
            }
            if passed_ms > 210 {
                prop_assert!(stopped_ms.is_some_and(|ms| ms <= 204), "{:?}", stopped_ms);
            }
        }

        /// For any course of the switch, a drive that is not stopped began with a release and a press, and the switch
        /// was never released for longer than allowed.
        #[test]
        fn no_drive_without_a_held_switch(levels in prop::collection::vec((any::<bool>(), 1u64..150), 1..30)) {
            let mut rig = Rig::new();
            let (mut opened, mut open_ms, mut closed_ms) = (false, 0, 0);
            for (closed, steps) in levels {
                rig.pass(2 * steps, closed, false);
                // Successive runs at one level count as one run.
                open_ms = if closed { 0 } else { open_ms + 2 * steps };
                closed_ms = if closed { closed_ms + 2 * steps } else { 0 };
                opened |= open_ms >= 50;
            }
            let starts = rig.pass(2, closed_ms > 0, true).is_none();
            if starts {
                prop_assert!(opened && closed_ms + 2 >= 20);
            }
        }
    }
}
