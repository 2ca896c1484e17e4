//! The device's web page, which states the counts per newton.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

/// Page of the device's settings (ATI 9620-05-NET FT).
const PAGE: &str = "/netftapi2.xml";
/// Largest size of a page, bytes.
const LIMIT_BYTES: u64 = 256 * 1024;

/// Settings stated by the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DevicePage {
    /// Counts per newton.
    pub counts_per_n: f64,
    /// Records that the device sends a second, RDT Output Rate.
    pub stated_hz: Option<f64>,
}

/// Force units in the order of the codes of `cfgfu`, from 1 on (ATI 9620-05-NET FT).
const FORCE_UNITS: [&str; 6] = ["lbf", "N", "klbf", "kN", "kg", "g"];

/// Reason why the page cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The device did not answer in time.
    #[error("no answer from http://{address}{PAGE}")]
    Unreachable {
        /// Address of the request.
        address: SocketAddr,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The server does not have this page.
    #[error("http://{address}{PAGE} answers \"{answer}\"")]
    NoPage {
        /// Address of the request.
        address: SocketAddr,
        /// First line of the answer.
        answer: String,
    },
    /// The page is not XML.
    #[error("http://{address}{PAGE} is not a Net F/T's page")]
    NotXml {
        /// Address of the request.
        address: SocketAddr,
        /// Error of the XML reader.
        source: roxmltree::Error,
    },
    /// A setting is missing or invalid.
    #[error("http://{address}{PAGE}: {why}")]
    Setting {
        /// Address of the request.
        address: SocketAddr,
        /// The setting and the defect.
        why: String,
    },
}

impl DevicePage {
    /// Requests the page of the device at `address`, with the timeout `patience`.
    ///
    /// # Errors
    /// [`PageError`] with the address and the answer.
    pub fn ask(address: SocketAddr, patience: Duration) -> Result<Self, PageError> {
        let answer = fetch(address, patience)
            .map_err(|source| PageError::Unreachable { address, source })?;
        let answer = String::from_utf8_lossy(&answer);
        let first = answer.lines().next().unwrap_or_default();
        let is_page = first
            .strip_prefix("HTTP/")
            .and_then(|rest| rest.split_whitespace().nth(1))
            .is_some_and(|code| code == "200");
        let body = answer.find('<').filter(|_| is_page);
        let Some(body) = body else {
            let answer = first.chars().take(80).collect();
            return Err(PageError::NoPage { address, answer });
        };
        Self::read(
            answer[body..].trim_end_matches(['\0', ' ', '\r', '\n']),
            address,
        )
    }

    fn read(page: &str, address: SocketAddr) -> Result<Self, PageError> {
        let xml = roxmltree::Document::parse(page)
            .map_err(|source| PageError::NotXml { address, source })?;
        let setting = |name: &str| {
            let mut elements = xml.descendants();
            let element = elements.find(|element| element.has_tag_name(name))?;
            element.text().map(str::trim)
        };
        let setting_error = |why: String| PageError::Setting { address, why };
        require_newtons(setting("scfgfu"), setting("cfgfu")).map_err(setting_error)?;
        let is_off = |state: &str| state == "0" || state.eq_ignore_ascii_case("disabled");
        if setting("comrdte").is_some_and(is_off) {
            return Err(setting_error(
                "the device does not send: enable RDT on its page Communications".to_owned(),
            ));
        }
        let stated_hz = setting("comrdtrate")
            .and_then(|rate| rate.parse().ok())
            .filter(|rate_hz| (1.0..=1e6).contains(rate_hz));
        let counts = setting("cfgcpf")
            .or_else(|| setting("calcpf"))
            .ok_or_else(|| setting_error("the counts per force, cfgcpf, are missing".to_owned()))?;
        match counts.parse() {
            Ok(counts_per_n) if (1.0..=1e9).contains(&counts_per_n) => Ok(Self {
                counts_per_n,
                stated_hz,
            }),
            _ => Err(setting_error(format!(
                "{counts} counts per force are out of 1 to 1e9"
            ))),
        }
    }
}

/// Requires the page's force unit, by its name `scfgfu` and its code `cfgfu`, to be the newton.
fn require_newtons(name: Option<&str>, code: Option<&str>) -> Result<(), String> {
    let name = name.filter(|name| !name.is_empty());
    let code = code.filter(|code| !code.is_empty());
    let coded_name = |code: &str| {
        let index = code.parse::<usize>().ok()?.checked_sub(1)?;
        FORCE_UNITS.get(index).copied()
    };
    let fault = match (name, code) {
        (None, None) => "the page states no force unit".to_owned(),
        (Some(name), _) if name != "N" => format!("the device counts in {name}"),
        (_, Some(code)) if coded_name(code) != Some("N") => format!(
            "the device counts in {} (cfgfu = {code})",
            coded_name(code).unwrap_or("an unknown unit")
        ),
        _ => return Ok(()),
    };
    Err(format!(
        "{fault}: set its force unit to N on its page of configurations"
    ))
}

/// Returns the whole answer; the server closes the connection.
fn fetch(address: SocketAddr, patience: Duration) -> std::io::Result<Vec<u8>> {
    let until = Instant::now() + patience;
    let mut stream = TcpStream::connect_timeout(&address, patience)?;
    stream.set_write_timeout(Some(patience))?;
    let request = format!("GET {PAGE} HTTP/1.0\r\nHost: {}\r\n\r\n", address.ip());
    stream.write_all(request.as_bytes())?;
    let (mut answer, mut piece) = (Vec::new(), [0; 4096]);
    while (answer.len() as u64) < LIMIT_BYTES {
        let remaining = until.saturating_duration_since(Instant::now());
        stream.set_read_timeout(Some(remaining.max(Duration::from_millis(1))))?;
        match stream.read(&mut piece)? {
            0 => break,
            read => answer.extend_from_slice(&piece[..read]),
        }
    }
    Ok(answer)
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    /// Returns the page read from a server's answer.
    fn page_from(answer: &'static str) -> Result<DevicePage, PageError> {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = server.local_addr().unwrap();
        let serving = std::thread::spawn(move || {
            let (mut stream, _) = server.accept().unwrap();
            let mut request = [0; 256];
            let read = stream.read(&mut request).unwrap();
            assert!(request[..read].starts_with(b"GET /netftapi2.xml HTTP/1.0\r\n"));
            stream.write_all(answer.as_bytes()).unwrap();
        });
        let page = DevicePage::ask(address, Duration::from_secs(5));
        serving.join().unwrap();
        page
    }

    #[test]
    fn the_counts_per_newton_are_read_from_the_page() {
        let page = page_from(
            "HTTP/1.0 200 OK\r\nContent-Type: text/xml\r\n\r\n<?xml version=\"1.0\"?><netftapi2><runstat>0x00000000</runstat>\
             <scfgfu>N</scfgfu><cfgcpf>1000000</cfgcpf><cfgcpt>1000000</cfgcpt><comrdte>Enabled</comrdte>\
             <comrdtrate>100</comrdtrate></netftapi2>\n",
        );
        let expected = DevicePage {
            counts_per_n: 1e6,
            stated_hz: Some(100.0),
        };
        assert_eq!(page.unwrap(), expected);
    }

    #[test]
    fn the_force_unit_is_never_assumed() {
        let fault = |name, code| require_newtons(name, code).err().unwrap_or_default();
        assert_eq!(fault(Some("N"), None), "");
        assert_eq!(fault(Some("N"), Some("2")), "");
        assert_eq!(fault(None, Some("2")), "");
        assert!(fault(None, Some("1")).contains("lbf (cfgfu = 1)"));
        assert!(fault(None, Some("6")).contains("counts in g "));
        assert!(fault(None, Some("9")).contains("unknown unit"));
        assert!(fault(Some("lbf"), Some("2")).contains("counts in lbf"));
        assert!(fault(Some("N"), Some("1")).contains("lbf"));
        assert!(fault(Some(""), None).contains("no force unit"));
    }

    #[test]
    fn a_useless_page_is_refused_with_its_fault() {
        let not_found = "HTTP/1.1 404 Not Found\r\n\r\n<html>404</html>";
        assert!(matches!(
            page_from(not_found),
            Err(PageError::NoPage { .. })
        ));
        assert!(matches!(page_from(""), Err(PageError::NoPage { .. })));
        let truncated = "HTTP/1.0 200 OK\r\n\r\n<netftapi2><cfgcpf>1";
        assert!(matches!(
            page_from(truncated),
            Err(PageError::NotXml { .. })
        ));
        for page in [
            "HTTP/1.0 200 OK\r\n\r\n<a><scfgfu>lbf</scfgfu><cfgcpf>1000</cfgcpf></a>",
            "HTTP/1.0 200 OK\r\n\r\n<a><scfgfu>N</scfgfu></a>",
            "HTTP/1.0 200 OK\r\n\r\n<a><cfgcpf>1000000</cfgcpf></a>",
            "HTTP/1.0 200 OK\r\n\r\n<a><scfgfu>N</scfgfu><cfgcpf>0</cfgcpf></a>",
            "HTTP/1.0 200 OK\r\n\r\n<a><scfgfu>N</scfgfu><cfgcpf>NaN</cfgcpf></a>",
            "HTTP/1.0 200 OK\r\n\r\n<a><scfgfu>N</scfgfu><cfgcpf>1000</cfgcpf><comrdte>Disabled</comrdte></a>",
        ] {
            assert!(
                matches!(page_from(page), Err(PageError::Setting { .. })),
                "{page}"
            );
        }
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr();
        let unreachable = DevicePage::ask(address.unwrap(), Duration::from_millis(200));
        assert!(matches!(unreachable, Err(PageError::Unreachable { .. })));
    }
}
