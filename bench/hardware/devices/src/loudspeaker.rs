//! The participant's loudspeaker: start and end tones, and noise that masks the plate's audible squeal. It is a
//! separate device, never the card that drives the plate, and the session continues if it fails.

use std::time::Duration;

use anyhow::Context;
use rodio::source::{SineWave, Source, noise::WhiteGaussian};
use rodio::{DeviceSinkBuilder, MixerDeviceSink, Player};

use config;

/// Pitch of the start tone, Hz; the end tone is an octave lower.
const START_HZ: f32 = 880.0;
const TONE: Duration = Duration::from_millis(200);
const FADE: Duration = Duration::from_millis(10);

/// The participant's loudspeaker or headphones.
pub struct Loudspeaker {
    sink: MixerDeviceSink,
    noise: Option<Player>,
    cues: bool,
    level: f32,
}

/// A cue to the participant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Begin to slide.
    Start,
    /// Stop sliding.
    End,
}

impl Loudspeaker {
    /// Opens the device that `[sound]` names; `None` if it names no device.
    ///
    /// # Errors
    /// If the device does not exist or cannot be opened: a warning for the operator, not the end of the session.
    pub fn open(
        host: &signalgen::audio::Host,
        sound: &config::Sound,
    ) -> anyhow::Result<Option<Self>> {
        if sound.device.is_empty() {
            return Ok(None);
        }
        let device = signalgen::audio::output_device(host, &sound.device)?;
        let mut sink = DeviceSinkBuilder::from_device(device)
            .and_then(|builder| builder.with_error_callback(|_| ()).open_stream())
            .with_context(|| format!("cannot play on {}", sound.device))?;
        sink.log_on_drop(false);
        let level = sound.level as f32;
        let noise = sound.masking_noise.then(|| {
            let player = Player::connect_new(sink.mixer());
            player.pause();
            // A quarter of the tones' level as standard deviation keeps the peaks of the noise below full scale.
            player.append(WhiteGaussian::new(sink.config().sample_rate()).amplify(level / 4.0));
            player
        });
        Ok(Some(Self {
            sink,
            noise,
            cues: sound.cues,
            level,
        }))
    }

    /// Plays a cue, if cues are on.
    pub fn play(&self, tone: Tone) {
        if !self.cues {
            return;
        }
        let pitch_hz = match tone {
            Tone::Start => START_HZ,
            Tone::End => START_HZ / 2.0,
        };
        let tone = SineWave::new(pitch_hz)
            .take_duration(TONE)
            .amplify(self.level)
            .fade_in(FADE);
        self.sink.mixer().add(tone.fade_out(TONE));
    }

    /// Turns the masking noise on or off.
    pub fn mask(&self, audible: bool) {
        if let Some(noise) = &self.noise {
            if audible { noise.play() } else { noise.pause() }
        }
    }
}
