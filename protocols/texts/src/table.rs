//! The table of texts, one row per text and one column per language.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::language::Language;

macro_rules! table {
    ($($(#[doc = $doc:literal])+ $name:ident: $en:literal, $fr:literal, $de:literal, $nl:literal;)+) => {
        /// Texts of the participant's screen, and the operator's words to the participant, named `say_…`.
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
    /// Notice that the trial is repeated because the finger left the plate.
    repeat_lifted: "Finger lifted: we will repeat this one", "Doigt levé : nous allons recommencer cet essai",
        "Finger abgehoben: wir wiederholen diesen Durchgang", "Vinger opgetild: we doen deze opnieuw";
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
    /// Operator's words when the consent is to be signed.
    say_consent: "Here is what we do, and your consent to sign.",
        "Voici ce que nous allons faire, et votre consentement à signer.",
        "Hier ist, was wir tun, und Ihre Einwilligung zum Unterschreiben.",
        "Dit gaan we doen, en hier is uw toestemming om te tekenen.";
    /// Operator's words at the beginning.
    say_welcome: "Welcome. Press the button when you are ready.",
        "Bienvenue. Appuyez sur le bouton quand vous êtes prêt.",
        "Willkommen. Drücken Sie den Knopf, wenn Sie bereit sind.",
        "Welkom. Druk op de knop als u klaar bent.";
    /// Operator's words at the beginning, on a bench without a button.
    say_welcome_without_button: "Welcome. Tell me when you are ready.",
        "Bienvenue. Dites-moi quand vous êtes prêt.",
        "Willkommen. Sagen Sie mir, wenn Sie bereit sind.",
        "Welkom. Zeg het als u klaar bent.";
    /// Operator's words when the dead-man switch is to be released.
    say_release_switch: "Let go of the hold button, please.",
        "Lâchez le bouton de maintien, s'il vous plaît.",
        "Bitte lassen Sie den Haltetaster los.",
        "Laat de vasthoudknop los, alstublieft.";
    /// Operator's words when the dead-man switch is to be held.
    say_hold_switch: "Press the hold button and keep it pressed.",
        "Appuyez sur le bouton de maintien et gardez-le enfoncé.",
        "Drücken Sie den Haltetaster und halten Sie ihn gedrückt.",
        "Druk op de vasthoudknop en houd hem ingedrukt.";
    /// Operator's words after the dead-man switch was released during a trial.
    say_switch_released: "You let go of the hold button: lift your finger, please.",
        "Vous avez lâché le bouton de maintien : levez le doigt, s'il vous plaît.",
        "Sie haben den Haltetaster losgelassen: Bitte heben Sie den Finger ab.",
        "U hebt de vasthoudknop losgelaten: til uw vinger op, alstublieft.";
    /// Operator's words while the plate is measured without a finger.
    say_baseline: "Keep your finger off the plate for a moment.",
        "Gardez le doigt loin de la plaque un instant.",
        "Lassen Sie den Finger einen Moment von der Platte weg.",
        "Houd uw vinger even van de plaat.";
    /// Operator's words when the finger is to leave the plate.
    say_lift_finger: "Lift your finger off the plate, please.",
        "Levez le doigt de la plaque, s'il vous plaît.",
        "Bitte heben Sie den Finger von der Platte ab.",
        "Til uw vinger van de plaat, alstublieft.";
    /// Operator's words when the finger is to rest on the start mark.
    say_place_finger: "Rest your finger on the plate at the mark, then press the button.",
        "Posez le doigt sur la plaque, sur le repère, puis appuyez sur le bouton.",
        "Legen Sie den Finger an der Marke auf die Platte, dann drücken Sie den Knopf.",
        "Leg uw vinger bij de markering op de plaat en druk dan op de knop.";
    /// The same on a bench without a button.
    say_place_finger_without_button: "Rest your finger on the plate at the mark, and keep it there.",
        "Posez le doigt sur la plaque, sur le repère, et gardez-le là.",
        "Legen Sie den Finger an der Marke auf die Platte und lassen Sie ihn dort.",
        "Leg uw vinger bij de markering op de plaat en houd hem daar.";
    /// Operator's words during the countdown.
    say_get_ready: "Get ready: the slider is about to move.",
        "Préparez-vous : le curseur va se déplacer.",
        "Machen Sie sich bereit: Der Schieber bewegt sich gleich.",
        "Maak u klaar: de schuif gaat zo bewegen.";
    /// Operator's words on a mean force in the band.
    say_just_right: "Just right.",
        "Très bien.",
        "Genau richtig.",
        "Precies goed.";
    /// Operator's words on a mean force below the band.
    say_press_harder: "Press a little harder.",
        "Appuyez un peu plus fort.",
        "Drücken Sie etwas fester.",
        "Druk iets harder.";
    /// Operator's words on a mean force above the band.
    say_press_lighter: "Press a little lighter.",
        "Appuyez un peu moins fort.",
        "Drücken Sie etwas leichter.",
        "Druk iets zachter.";
    /// Operator's words after an exploration without a measured force.
    say_thanks: "Thank you.",
        "Merci.",
        "Danke.",
        "Dank u.";
    /// Operator's words when a trial is repeated.
    say_again: "We do this one once more, please.",
        "Nous refaisons cet essai encore une fois, s'il vous plaît.",
        "Diesen Durchgang machen wir bitte noch einmal.",
        "Deze doen we nog een keer, alstublieft.";
    /// Operator's words while the bench is busy.
    say_wait: "One moment, please.",
        "Un instant, s'il vous plaît.",
        "Einen Moment, bitte.",
        "Een ogenblik, alstublieft.";
    /// Operator's words at the beginning of a break of `{seconds}` s.
    say_rest: "Have a rest. We can go on in {seconds} s.",
        "Reposez-vous. Nous pourrons continuer dans {seconds} s.",
        "Ruhen Sie sich aus. In {seconds} s können wir weitermachen.",
        "Rust even uit. Over {seconds} s kunnen we verder.";
    /// Operator's words at the end of a break.
    say_rest_over: "Press the button when you are rested.",
        "Appuyez sur le bouton quand vous êtes reposé.",
        "Drücken Sie den Knopf, wenn Sie ausgeruht sind.",
        "Druk op de knop als u uitgerust bent.";
    /// The same on a bench without a button.
    say_rest_over_without_button: "Tell me when you are rested.",
        "Dites-moi quand vous êtes reposé.",
        "Sagen Sie mir, wenn Sie ausgeruht sind.",
        "Zeg het als u uitgerust bent.";
    /// Operator's words in a pause.
    say_paused: "A short break: lift your finger, please.",
        "Une courte pause : levez le doigt, s'il vous plaît.",
        "Eine kurze Pause: Bitte heben Sie den Finger ab.",
        "Een korte pauze: til uw vinger op, alstublieft.";
    /// Operator's words after the drive was stopped.
    say_stopped: "Lift your finger off the plate, please. We have to stop for a moment.",
        "Levez le doigt de la plaque, s'il vous plaît. Nous devons nous arrêter un instant.",
        "Bitte heben Sie den Finger von der Platte ab. Wir müssen kurz anhalten.",
        "Til uw vinger van de plaat, alstublieft. We moeten even stoppen.";
    /// Operator's words at the end.
    say_finished: "That was all. Thank you!",
        "C'est terminé. Merci beaucoup !",
        "Das war alles. Vielen Dank!",
        "Dat was alles. Hartelijk dank!";
    /// Operator's words at the end of an aborted session.
    say_aborted: "We stop here. Thank you for coming.",
        "Nous nous arrêtons ici. Merci d'être venu.",
        "Wir hören hier auf. Danke, dass Sie da waren.",
        "We stoppen hier. Bedankt voor uw komst.";
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
