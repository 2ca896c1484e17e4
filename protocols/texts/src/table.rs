//! The table of texts, one row per text and one column per language.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::language::Language;

macro_rules! table {
    ($($(#[doc = $doc:literal])+ $name:ident: $en:literal, $fr:literal, $de:literal, $nl:literal;)+) => {
        /// Texts of the participant's screen.
        #[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct Texts {
            $($(#[doc = $doc])+ pub $name: Cow<'static, str>,)+
        }

        /// Texts of the laboratory, in place of those of the protocol's language: each 1 to 120 characters on one line.
        #[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        pub struct OwnTexts {
            $(
                $(#[doc = $doc])+
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $name: Option<String>,
            )+
        }

        static ENGLISH: Texts = Texts { $($name: Cow::Borrowed($en),)+ };
        static FRENCH: Texts = Texts { $($name: Cow::Borrowed($fr),)+ };
        static GERMAN: Texts = Texts { $($name: Cow::Borrowed($de),)+ };
        static DUTCH: Texts = Texts { $($name: Cow::Borrowed($nl),)+ };

        impl Texts {
            /// Returns these texts, replaced by those of `replacements` that are given.
            #[must_use]
            pub fn replaced_by(&self, replacements: &OwnTexts) -> Self {
                Self {
                    $($name: replacements.$name.clone().map_or_else(|| self.$name.clone(), Cow::Owned),)+
                }
            }

            /// Returns the name and the wording of every text.
            pub fn all(&self) -> impl Iterator<Item = (&'static str, &str)> {
                [$((stringify!($name), self.$name.as_ref()),)+].into_iter()
            }
        }

        impl OwnTexts {
            /// Returns the name and the wording of every text that is given.
            pub fn replacements(&self) -> impl Iterator<Item = (&'static str, &str)> {
                [$((stringify!($name), self.$name.as_deref()),)+]
                    .into_iter()
                    .filter_map(|(name, words)| Some((name, words?)))
            }
        }
    };
}

table! {
    /// Request to wait.
    wait: "Please wait", "Veuillez patienter", "Bitte warten", "Even wachten";
    /// Request to begin the session with the button.
    welcome: "Press the button to begin", "Appuyez sur le bouton pour commencer",
        "Drücken Sie den Knopf, um zu beginnen", "Druk op de knop om te beginnen";
    /// Notice that the session is about to begin, on a bench without a button.
    welcome_without_button: "We are about to begin", "Nous allons commencer", "Es geht gleich los", "We gaan zo beginnen";
    /// Request to release the dead-man switch.
    release_switch: "Release the hold button", "Relâchez le bouton de maintien",
        "Lassen Sie den Haltetaster los", "Laat de vasthoudknop los";
    /// Request to press and hold the dead-man switch.
    hold_switch: "Press the hold button and keep it pressed", "Appuyez sur le bouton de maintien et gardez-le enfoncé",
        "Drücken Sie den Haltetaster und halten Sie ihn gedrückt", "Druk op de vasthoudknop en houd hem ingedrukt";
    /// Notice that the dead-man switch was released during a trial.
    switch_released: "You released the hold button. Please lift your finger",
        "Vous avez relâché le bouton de maintien. Levez le doigt, s'il vous plaît",
        "Sie haben den Haltetaster losgelassen. Bitte heben Sie den Finger ab",
        "U hebt de vasthoudknop losgelaten. Til uw vinger op";
    /// Request to lift the finger off the plate.
    lift_finger: "Lift your finger off the plate", "Levez le doigt de la plaque",
        "Heben Sie den Finger von der Platte ab", "Til uw vinger van de plaat";
    /// Request to rest the finger on the start mark.
    place_finger: "Place your finger on the start mark", "Posez le doigt sur le repère de départ",
        "Legen Sie den Finger auf die Startmarke", "Leg uw vinger op het startpunt";
    /// Continuation of `place_finger` on a bench with a button.
    then_press: "then press the button", "puis appuyez sur le bouton",
        "drücken Sie dann den Knopf", "druk dan op de knop";
    /// Continuation of `place_finger` on a bench without a button.
    then_rest: "and keep it there", "et gardez-le là", "und lassen Sie ihn dort", "en houd hem daar";
    /// Notice that the slider is about to move.
    get_ready: "Get ready", "Préparez-vous", "Machen Sie sich bereit", "Maak u klaar";
    /// Request to follow the moving slider.
    follow_slider: "Follow the slider", "Suivez le curseur", "Folgen Sie dem Schieber", "Volg de schuif";
    /// Heading of the mean force of an exploration.
    feedback: "Your mean force", "Votre force moyenne", "Ihre mittlere Kraft", "Uw gemiddelde kracht";
    /// Mean force below the band.
    too_light: "too light", "trop léger", "zu leicht", "te licht";
    /// Mean force in the band.
    just_right: "just right", "très bien", "genau richtig", "precies goed";
    /// Mean force above the band.
    too_hard: "too hard", "trop fort", "zu fest", "te hard";
    /// Mean force unknown.
    not_measured: "not measured", "non mesurée", "nicht gemessen", "niet gemeten";
    /// Notice that the trial is repeated because the finger was slower than the slider.
    repeat_slow: "Too slow: we will repeat this one", "Trop lent : nous allons recommencer cet essai",
        "Zu langsam: wir wiederholen diesen Durchgang", "Te langzaam: we doen deze opnieuw";
    /// Notice that the trial is repeated because the finger was faster than the slider.
    repeat_fast: "Too fast: we will repeat this one", "Trop rapide : nous allons recommencer cet essai",
        "Zu schnell: wir wiederholen diesen Durchgang", "Te snel: we doen deze opnieuw";
    /// Notice that the trial is repeated because the finger pressed too little.
    repeat_light: "Too light: we will repeat this one", "Trop léger : nous allons recommencer cet essai",
        "Zu leicht: wir wiederholen diesen Durchgang", "Te licht: we doen deze opnieuw";
    /// Notice that the trial is repeated because the finger pressed too much.
    repeat_hard: "Too hard: we will repeat this one", "Trop fort : nous allons recommencer cet essai",
        "Zu fest: wir wiederholen diesen Durchgang", "Te hard: we doen deze opnieuw";
    /// Notice that the trial is repeated for a reason not due to the participant.
    repeat: "We will repeat this one", "Nous allons recommencer cet essai",
        "Wir wiederholen diesen Durchgang", "We doen deze opnieuw";
    /// Notice of a break.
    rest: "Take a break", "Faites une pause", "Machen Sie eine Pause", "Neem een pauze";
    /// Request to end the break with the button.
    rest_over: "Press the button to go on", "Appuyez sur le bouton pour continuer",
        "Drücken Sie den Knopf, um weiterzumachen", "Druk op de knop om verder te gaan";
    /// Notice that the session is paused.
    paused: "Paused. Please lift your finger", "Pause. Levez le doigt, s'il vous plaît",
        "Unterbrochen. Bitte heben Sie den Finger ab", "Onderbroken. Til uw vinger op";
    /// Notice that the session is over.
    finished: "Finished. Thank you!", "C'est terminé. Merci !", "Fertig. Vielen Dank!", "Klaar. Hartelijk dank!";
    /// Number of the trial: `{number}` of `{total}`.
    trial: "trial {number} of {total}", "essai {number} sur {total}",
        "Durchgang {number} von {total}", "proef {number} van {total}";
    /// Number of the practice trial: `{number}` of `{total}`.
    practice: "practice {number} of {total}", "entraînement {number} sur {total}",
        "Übung {number} von {total}", "oefening {number} van {total}";
    /// Start of the exploration.
    start: "start", "départ", "Start", "start";
    /// End of the exploration.
    end: "end", "arrivée", "Ende", "einde";
    /// Decimal mark of numbers.
    decimal_mark: ".", ",", ",", ",";
}

impl Texts {
    /// Returns the texts of a language.
    #[must_use]
    pub fn in_language(language: Language) -> &'static Self {
        match language {
            Language::En => &ENGLISH,
            Language::Fr => &FRENCH,
            Language::De => &GERMAN,
            Language::Nl => &DUTCH,
        }
    }
}

impl Default for Texts {
    fn default() -> Self {
        ENGLISH.clone()
    }
}
