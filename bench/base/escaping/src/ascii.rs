//! Texts for terminals and files without UTF-8.

use std::borrow::Cow;

/// Returns `text` in ASCII: signs by their usual transcription, Greek letters by their names, Latin letters without accents, and
/// all else as `\u65e5`.
///
/// ```
/// assert_eq!(escaping::ascii("0.0 ± 0.4 Hz → 3 µm…"), "0.0 +- 0.4 Hz -> 3 um...");
/// assert_eq!(escaping::ascii("σ_t in N·s/m², Größe"), "sigma_t in N*s/m^2, Groesse");
/// ```
#[must_use]
pub fn ascii(text: &str) -> Cow<'_, str> {
    if text.is_ascii() {
        return Cow::Borrowed(text);
    }
    let mut output = String::with_capacity(text.len() + 16);
    let mut in_exponent = false;
    for c in text.chars() {
        let exponent = exponent(c);
        if exponent.is_some() && !in_exponent {
            output.push('^');
        }
        in_exponent = exponent.is_some();
        match exponent {
            Some(sign) => output.push(sign),
            None if c.is_ascii() => output.push(c),
            None => match transcription(c) {
                Some(signs) => output.push_str(signs),
                None => output.push_str(&format!("\\u{:04x}", u32::from(c))),
            },
        }
    }
    Cow::Owned(output)
}

fn exponent(c: char) -> Option<char> {
    Some(match c {
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁴'..='⁹' => char::from(b'4' + (u32::from(c) - u32::from('⁴')) as u8),
        '⁺' => '+',
        '⁻' => '-',
        _ => return None,
    })
}

fn transcription(c: char) -> Option<&'static str> {
    Some(match c {
        // The micro sign, and the Greek letter that is written for it.
        'µ' | 'μ' => "u",
        '±' => "+-",
        '∓' => "-+",
        '·' | '⋅' | '∙' => "*",
        '×' => "x",
        '÷' => ":",
        '≤' => "<=",
        '≥' => ">=",
        '≪' => "<<",
        '≫' => ">>",
        '≈' | '∼' | '≃' => "~",
        '≠' => "!=",
        '≡' => "==",
        '√' => "sqrt",
        '∞' => "inf",
        '∂' => "d",
        '∫' => "integral",
        '∑' => "sum",
        '∝' => "~",
        '∈' => "in",
        '∥' => "||",
        '°' => "deg",
        '′' => "'",
        '″' => "\"",
        '‰' => "per mille",
        '−' | '–' | '‐' | '‑' | '‒' => "-",
        '—' | '―' => "--",
        '…' => "...",
        '→' | '⟶' | '➜' | '▸' | '▶' => "->",
        '←' | '◂' | '◀' => "<-",
        '↔' | '⟷' => "<->",
        '⇒' | '⟹' => "=>",
        '↑' | '▲' | '△' => "^",
        '↓' | '▼' | '▽' => "v",
        '“' | '”' | '„' | '‟' | '«' | '»' => "\"",
        '‘' | '’' | '‚' | '‛' | '‹' | '›' => "'",
        '\u{a0}' | '\u{2000}'..='\u{200a}' | '\u{202f}' | '\u{205f}' | '\u{3000}' => " ",
        '\u{ad}' | '\u{200b}'..='\u{200d}' | '\u{2060}' | '\u{feff}' => "",
        '•' | '●' | '◆' | '■' | '▪' => "*",
        '○' | '◇' | '□' => "o",
        '✓' | '✔' => "+",
        '✗' | '✘' | '✕' => "x",
        '§' => "section ",
        '©' => "(c)",
        '®' => "(R)",
        '™' => "(TM)",
        '€' => "EUR",
        '£' => "GBP",
        '¼' => "1/4",
        '½' => "1/2",
        '¾' => "3/4",
        '\u{3a9}' | '\u{2126}' => "Ohm",
        'ℓ' => "l",
        '¦' => "|",
        '─' | '━' | '═' | '╌' | '┄' => "-",
        '│' | '┃' | '║' | '▏' => "|",
        '┌' | '┐' | '└' | '┘' | '├' | '┤' | '┬' | '┴' | '┼' => "+",
        '█' | '▓' | '▌' | '▐' | '▀' | '▄' => "#",
        '▒' | '░' => ":",
        _ => return greek(c).or_else(|| latin(c)).or_else(|| subscript(c)),
    })
}

fn greek(c: char) -> Option<&'static str> {
    Some(match c {
        'α' => "alpha",
        'β' => "beta",
        'γ' => "gamma",
        'δ' => "delta",
        'ε' | 'ϵ' => "epsilon",
        'ζ' => "zeta",
        'η' => "eta",
        'θ' | 'ϑ' => "theta",
        'ι' => "iota",
        'κ' => "kappa",
        'λ' => "lambda",
        'ν' => "nu",
        'ξ' => "xi",
        'π' => "pi",
        'ρ' => "rho",
        'σ' | 'ς' => "sigma",
        'τ' => "tau",
        'φ' | 'ϕ' => "phi",
        'χ' => "chi",
        'ψ' => "psi",
        'ω' => "omega",
        'Γ' => "Gamma",
        'Δ' | '∆' => "Delta",
        'Θ' => "Theta",
        'Λ' => "Lambda",
        'Π' => "Pi",
        'Σ' => "Sigma",
        'Φ' => "Phi",
        'Ψ' => "Psi",
        _ => return None,
    })
}

/// Transcribes letters of Western European languages, German umlauts with an e.
fn latin(c: char) -> Option<&'static str> {
    Some(match c {
        'ä' | 'æ' => "ae",
        'ö' | 'œ' => "oe",
        'ü' => "ue",
        'ß' => "ss",
        'Ä' | 'Æ' => "Ae",
        'Ö' | 'Œ' => "Oe",
        'Ü' => "Ue",
        'à' | 'á' | 'â' | 'ã' | 'å' | 'ā' => "a",
        'ç' | 'č' | 'ć' => "c",
        'è' | 'é' | 'ê' | 'ë' | 'ē' | 'ě' => "e",
        'ì' | 'í' | 'î' | 'ï' => "i",
        'ł' => "l",
        'ñ' | 'ń' => "n",
        'ò' | 'ó' | 'ô' | 'õ' | 'ø' => "o",
        'ř' => "r",
        'š' | 'ś' => "s",
        'ù' | 'ú' | 'û' | 'ů' => "u",
        'ý' | 'ÿ' => "y",
        'ž' | 'ź' | 'ż' => "z",
        'À' | 'Á' | 'Â' | 'Ã' | 'Å' => "A",
        'Ç' | 'Č' => "C",
        'È' | 'É' | 'Ê' | 'Ë' => "E",
        'Ì' | 'Í' | 'Î' | 'Ï' => "I",
        'Ł' => "L",
        'Ñ' => "N",
        'Ò' | 'Ó' | 'Ô' | 'Õ' | 'Ø' => "O",
        'Š' => "S",
        'Ù' | 'Ú' | 'Û' => "U",
        'Ž' => "Z",
        _ => return None,
    })
}

/// Transcribes indices below the line.
fn subscript(c: char) -> Option<&'static str> {
    Some(match c {
        '₀' => "0",
        '₁' => "1",
        '₂' => "2",
        '₃' => "3",
        '₄' => "4",
        '₅' => "5",
        '₆' => "6",
        '₇' => "7",
        '₈' => "8",
        '₉' => "9",
        'ₐ' => "a",
        'ₑ' => "e",
        'ᵢ' => "i",
        'ₘ' => "m",
        'ₙ' => "n",
        'ₚ' => "p",
        'ₛ' => "s",
        'ₜ' => "t",
        'ₓ' => "x",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_becomes_ascii_and_keeps_its_meaning() {
        for (text, expected) in [
            ("plain\ttext\n", "plain\ttext\n"),
            ("Z_m 0.3 N·s/m ± 2 %", "Z_m 0.3 N*s/m +- 2 %"),
            ("10⁻³ s⁻¹, m²", "10^-3 s^-1, m^2"),
            ("0.50–0.80 N, 35 °C", "0.50-0.80 N, 35 degC"),
            ("„a“ ‘b’ – c", "\"a\" 'b' - c"),
            ("Δμ, ωτ ≤ ½", "Deltau, omegatau <= 1/2"),
            ("α₀ ≈ β", "alpha0 ~ beta"),
            ("日.wav", "\\u65e5.wav"),
        ] {
            assert_eq!(ascii(text), expected);
        }
        let all: String = ('\0'..='\u{ffff}').collect();
        assert!(ascii(&all).is_ascii());
    }
}
