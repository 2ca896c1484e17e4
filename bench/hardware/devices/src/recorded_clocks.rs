//! Clocks of the sensors during a recording, for its manifest.

use impedance::clock_alignment::ClockState;
use recording::manifest::{ClockDevice, RecordedClock};

use crate::gauges::DeviceReadings;

/// State of the clocks during a recording: the latest drift of each, and the greatest residual.
#[derive(Debug, Default)]
pub(crate) struct RecordedClocks([Option<RecordedClock>; 3]);

impl RecordedClocks {
    /// Takes the present state of the clocks.
    pub(crate) fn look(&mut self, gauges: &DeviceReadings) {
        let Some(card) = gauges.card_clock.get() else {
            return;
        };
        let field = gauges.field.get().unwrap_or_default();
        let against_card = |clock: Option<ClockState>| {
            let clock = clock?;
            Some((clock.fast_ppm_against(&card)?, clock.residual_s))
        };
        let card_itself = card.fast_ppm().map(|ppm| (ppm, card.residual_s));
        let now = [
            (ClockDevice::SoundCard, card_itself),
            (ClockDevice::ForceSensor, against_card(field.force_clock)),
            (ClockDevice::Encoder, against_card(field.position_clock)),
        ];
        for (known, (source, state)) in self.0.iter_mut().zip(now) {
            let Some((drift_ppm, residual_s)) = state else {
                continue;
            };
            let previous_s = known.as_ref().and_then(|known| known.residual_s);
            *known = Some(RecordedClock {
                of: source,
                drift_ppm,
                residual_s: previous_s.into_iter().chain(residual_s).reduce(f64::max),
            });
        }
    }

    /// Returns the clocks that are known.
    pub(crate) fn entries(&self) -> Vec<RecordedClock> {
        self.0.iter().flatten().cloned().collect()
    }
}
