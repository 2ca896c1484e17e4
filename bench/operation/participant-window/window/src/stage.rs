//! Contents of each frame, from the session's messages.

use std::collections::HashSet;

use participant_window::bench_clock::BenchClock;
use participant_window::fitness::{Fitness, OnMonitor};
use participant_window::frame_log::FrameLog;
use participant_window::geometry::Geometry;
use participant_window::lettering::Typeface;
use participant_window::message::{Beat, Content, FromWindow, ToWindow};
use participant_window::page::Moving;

/// Latest contents from the session, and the bench's clock.
#[derive(Default)]
pub struct Stage {
    content: Content,
    clock: BenchClock,
    finger_m: Option<f64>,
    /// Whether a session is connected.
    running: bool,
    log: Option<FrameLog>,
    fitness: Fitness,
    reported: HashSet<String>,
}

impl Stage {
    /// Takes a message of the session.
    pub fn take(&mut self, message: ToWindow) {
        match message {
            ToWindow::Welcome { .. } => {
                self.clock = BenchClock::default();
                self.reported.clear();
                self.fitness.forget();
                self.running = true;
            }
            ToWindow::Refused { why } => self.show_loss(&why),
            ToWindow::Show(content) => self.content = *content,
            ToWindow::Beat(beat) => self.beat(&beat),
            ToWindow::Bye => {
                // The last words stay on the screen.
                self.running = false;
                self.content.track = None;
                self.content.until_s = None;
            }
        }
    }

    fn beat(&mut self, beat: &Beat) {
        self.clock.take(beat);
        self.finger_m = beat.finger_m;
    }

    /// Notes that no session is connected, or that it ended without a message.
    pub fn show_loss(&mut self, reason: &str) {
        if self.running || self.content.title.is_empty() {
            self.content = Content {
                title: std::mem::take(&mut self.content.silent),
                then: Some(reason.to_owned()),
                ..Content::default()
            };
        }
        self.running = false;
        self.log = None;
    }

    /// Shows that no session has connected yet.
    pub fn show_waiting(&mut self) {
        if !self.running && self.content.title.is_empty() {
            self.content.then = Some("no session yet  ·  Ctrl-R ruler  ·  Ctrl-Q close".to_owned());
        }
    }

    /// Returns the contents at `aim_s` on the shared clock, and the time on the bench's clock then.
    pub fn frame_at(&self, aim_s: f64) -> (Content, Option<f64>, Moving) {
        let audio_s = self.clock.audio_s(aim_s);
        let (Some(now_s), true) = (audio_s, self.running) else {
            // Without the bench's clock the slider is not shown.
            let silent = self.running && self.content.track.is_some();
            let content = Content {
                title: if silent {
                    self.content.silent.clone()
                } else {
                    self.content.title.clone()
                },
                then: self.content.then.clone().filter(|_| !silent),
                track: None,
                until_s: None,
                ..self.content.clone()
            };
            return (content, None, Moving::default());
        };
        let moving = Moving {
            slider_m: self
                .content
                .track
                .as_ref()
                .map(|track| track.motion.at_m(now_s)),
            finger_m: self.finger_m.filter(|_| self.content.track.is_some()),
        };
        (self.content.clone(), audio_s, moving)
    }

    /// Returns whether the slider moves at `shared_s` on the shared clock.
    pub fn moves(&self, shared_s: f64) -> bool {
        let (Some(audio_s), Some(track)) = (self.clock.audio_s(shared_s), &self.content.track)
        else {
            return false;
        };
        self.running && track.motion.moves(audio_s)
    }

    /// Takes a frame that was presented at `shared_s`; returns the report once an exploration is over.
    pub fn presented(
        &mut self,
        shared_s: f64,
        slider_m: Option<f64>,
        refresh_s: f64,
    ) -> Option<FromWindow> {
        let audio_s = self.clock.audio_s(shared_s);
        let motion = self.content.track.as_ref().map(|track| track.motion);
        let moving = motion
            .zip(audio_s)
            .filter(|(motion, audio_s)| self.running && motion.moves(*audio_s));
        let Some(((motion, audio_s), slider_m)) = moving.zip(slider_m) else {
            self.fitness.note_rest();
            let report = self.log.take()?.report()?;
            return Some(FromWindow::Explored(report));
        };
        self.fitness.note_frame(shared_s);
        let mut report = None;
        if self.log.as_ref().is_some_and(|log| *log.motion() != motion) {
            report = self
                .log
                .take()
                .and_then(|log| log.report())
                .map(FromWindow::Explored);
        }
        self.log
            .get_or_insert_with(|| FrameLog::new(motion, refresh_s))
            .take(audio_s, slider_m);
        report
    }

    /// Returns whether a finger can follow the window, if this is news for the session.
    pub fn fit(
        &mut self,
        shared_s: f64,
        expected: &OnMonitor,
        current: Option<&OnMonitor>,
    ) -> Option<FromWindow> {
        self.fitness.set_monitor(expected, current);
        let virtual_display = super::monitor::is_virtual(&expected.name);
        self.fitness
            .news(shared_s, virtual_display)
            .filter(|_| self.running)
    }

    /// Returns warnings for the operator about the contents, each once.
    pub fn troubles(&mut self, geometry: Geometry, face: &Typeface) -> Vec<FromWindow> {
        let mut troubles = Vec::new();
        if let Some(track) = self
            .content
            .track
            .as_ref()
            .filter(|track| !geometry.fits(track))
        {
            troubles.push(format!(
                "the plate of {:.0} mm does not fit on this monitor, which is {:.0} mm wide: it is drawn smaller, not \
                 true to the millimetre; use a wider monitor, or match the ruler page (Ctrl-R)",
                1e3 * track.plate_m,
                1e3 * geometry.width * geometry.pixel_m
            ));
        }
        let texts = [
            Some(&self.content.title),
            self.content.then.as_ref(),
            self.content.progress.as_ref(),
        ];
        let missing_letter = texts
            .into_iter()
            .flatten()
            .find_map(|text| face.lacks(text));
        if let Some(letter) = missing_letter {
            troubles.push(format!(
                "the window's font has no {letter:?}: start it with --font and a file that has"
            ));
        }
        let reported = &mut self.reported;
        troubles.retain(|text| reported.insert(text.clone()));
        troubles
            .into_iter()
            .map(|text| FromWindow::Trouble { text })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use participant_window::message::{FORMAT, Track};
    use participant_window::motion::Motion;

    fn stage(starts_s: Option<f64>) -> Stage {
        let mut stage = Stage::default();
        stage.take(ToWindow::Welcome { format: FORMAT });
        stage.take(ToWindow::Show(Box::new(Content {
            title: "Follow the slider".to_owned(),
            silent: "Paused".to_owned(),
            track: Some(Track {
                plate_m: 0.105,
                motion: Motion {
                    from_m: 0.01,
                    to_m: 0.095,
                    speed_m_per_s: 0.05,
                    starts_s,
                },
                marks: ("start".to_owned(), "end".to_owned()),
                place: false,
            }),
            ..Content::default()
        })));
        stage.take(ToWindow::Beat(Beat {
            audio_s: 0.0,
            shared_s: 100.0,
            finger_m: None,
        }));
        stage
    }

    #[test]
    fn the_slider_goes_on_between_messages_and_stops_with_a_silent_bench() {
        let stage = stage(Some(0.2));
        let slider_m = |shared_s| stage.frame_at(shared_s).2.slider_m;
        assert_eq!(slider_m(100.1), Some(0.01));
        assert!((slider_m(100.9).unwrap() - 0.045).abs() < 1e-9);
        let (content, audio_s, moving) = stage.frame_at(101.5);
        assert_eq!((content.title.as_str(), audio_s), ("Paused", None));
        assert_eq!((content.track, moving), (None, Moving::default()));
    }

    #[test]
    fn a_session_that_is_lost_says_so_and_one_that_ends_keeps_its_last_words() {
        let mut lost_stage = stage(Some(0.2));
        lost_stage.show_loss("the session is gone");
        assert_eq!(lost_stage.frame_at(100.5).0.title, "Paused");
        let mut ended_stage = stage(None);
        ended_stage.take(ToWindow::Bye);
        ended_stage.show_loss("the session is gone");
        assert_eq!(ended_stage.frame_at(100.5).0.title, "Follow the slider");
        assert_eq!(ended_stage.frame_at(100.5).0.track, None);
    }

    #[test]
    fn each_exploration_is_reported_once() {
        let mut stage = stage(Some(0.0));
        let mut reports = Vec::new();
        for i in 0..130 {
            let shared_s = 100.0 + f64::from(i) / 60.0;
            stage.take(ToWindow::Beat(Beat {
                audio_s: shared_s - 100.0,
                shared_s,
                finger_m: None,
            }));
            let slider_m = stage.frame_at(shared_s).2.slider_m;
            reports.extend(stage.presented(shared_s, slider_m, 1.0 / 60.0));
        }
        let [FromWindow::Explored(report)] = &reports[..] else {
            panic!("{reports:?}");
        };
        assert_eq!((report.frames, report.dropped), (102, 0));
    }

    #[test]
    fn the_operator_is_warned_once_of_an_oversized_plate_and_of_missing_letters() {
        let mut stage = stage(None);
        let narrow = Geometry {
            width: 300.0,
            height: 200.0,
            pixel_m: 2.5e-4,
        };
        let face = Typeface::default_face().unwrap();
        assert_eq!(stage.troubles(narrow, &face).len(), 1);
        assert!(stage.troubles(narrow, &face).is_empty());
        stage.content.title = "準備".to_owned();
        assert_eq!(stage.troubles(narrow, &face).len(), 1);
    }
}
