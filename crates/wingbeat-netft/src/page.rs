//! What stands in the box's configuration pages.

use std::collections::BTreeMap;

use wingbeat::rig::netft::{BOX_RATE, Scale};
use xml::reader::{ParserConfig2, XmlEvent};

/// Deepest nesting of a page's elements.
const DEEPEST: usize = 16;

/// What the box says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Counts per N and N m.
    pub scale: Scale,
    /// Records per second that it says to send, Hz, where the page says it.
    pub rate_hz: Option<f64>,
    /// Where it was found.
    pub page: String,
}

impl Config {
    /// Reads cfgcpf, cfgcpt with the units scfgfu, scfgtu and comrdtrate (`/netftapi2.xml`), or
    /// calcpf, calcpt with calfu, caltu (`/netftcalapi.xml`).
    ///
    /// # Errors
    /// A page that is not whole XML, an element that is missing or stands twice, a number or a unit that is not
    /// believed.
    pub fn of_page(bytes: &[u8], page: &str) -> Result<Self, String> {
        let elements = elements(bytes)?;
        let said = |a: &'static str, b: &'static str| {
            let found = elements.get(a).map(|text| (a, text)).or_else(|| Some((b, elements.get(b)?)));
            let (name, text) = found.ok_or_else(|| format!("no element <{a}> or <{b}>"))?;
            match text {
                Some(text) => Ok((name, text.as_str())),
                None => Err(format!("element <{name}> stands there with different values")),
            }
        };
        let force = [said("cfgcpf", "calcpf")?, said("scfgfu", "calfu")?];
        let moment = [said("cfgcpt", "calcpt")?, said("scfgtu", "caltu")?];
        let rate = said("comrdtrate", "comrdtrate").ok().map(|(_, text)| rate(text)).transpose()?;
        let scale = Scale::stated(force, moment).map_err(|error| error.to_string())?;
        Ok(Self { scale, rate_hz: rate, page: page.into() })
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (1.0..=BOX_RATE).contains(rate));
    rate.ok_or_else(|| format!("comrdtrate = {text}: allowed is 1 to {BOX_RATE} Hz"))
}

/// The texts of the elements that hold no others, by name; none where one stands with different texts.
fn elements(bytes: &[u8]) -> Result<BTreeMap<String, Option<String>>, String> {
    let config = ParserConfig2::new()
        .trim_whitespace(true)
        .cdata_to_characters(true)
        .ignore_invalid_encoding_declarations(true)
        .replace_unknown_entity_references(true)
        .max_entity_expansion_depth(1);
    let mut found: BTreeMap<String, Option<String>> = BTreeMap::new();
    let (mut depth, mut leaf, mut text) = (0, false, String::new());
    for event in config.create_reader(bytes) {
        match event.map_err(|error| format!("not a whole page of XML: {error}"))? {
            XmlEvent::StartElement { .. } => {
                (depth, leaf) = (depth + 1, true);
                text.clear();
            }
            XmlEvent::Characters(part) => text += &part,
            XmlEvent::EndElement { name } => {
                depth -= 1;
                if std::mem::take(&mut leaf) {
                    let value = text.trim().to_owned();
                    let entry = found.entry(name.local_name).or_insert_with(|| Some(value.clone()));
                    *entry = entry.take().filter(|earlier| *earlier == value);
                }
            }
            _ => {}
        }
        if depth > DEEPEST {
            return Err(format!("elements nested more than {DEEPEST} deep"));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "<?xml version=\"1.0\"?><netft><cfgcpf>1000000</cfgcpf><cfgcpt>1000</cfgcpt>\
                        <scfgfu>N</scfgfu><scfgtu>Nmm</scfgtu><comrdtrate>3500</comrdtrate></netft>";

    fn read(page: &str) -> Result<Config, String> {
        Config::of_page(page.as_bytes(), "/")
    }

    #[test]
    fn a_page_says_scale_and_rate() {
        let config = read(PAGE).unwrap();
        assert_eq!((config.scale.per_newton, config.scale.per_newton_metre), (1e6, 1e6));
        assert_eq!(config.rate_hz, Some(3500.0));
        let calibration = PAGE.replace("scfgfu", "calfu").replace("scfgtu", "caltu").replace("cfg", "cal");
        assert_eq!(read(&calibration).unwrap(), config);
        assert_eq!(read(&PAGE.replace("comrdtrate", "other")).unwrap().rate_hz, None);
    }

    #[test]
    fn what_stands_in_comments_is_not_read() {
        let commented = PAGE.replace("<netft>", "<netft><!-- <cfgcpf>7</cfgcpf> -->");
        assert_eq!(read(&commented).unwrap().scale.per_newton, 1e6);
        let hidden = PAGE.replace("<cfgcpf>1000000</cfgcpf>", "<!-- <cfgcpf>7</cfgcpf> -->");
        assert!(read(&hidden).unwrap_err().contains("no element <cfgcpf> or <calcpf>"));
        let text = PAGE.replace("<netft>", "<netft note='<cfgcpf>7</cfgcpf>'>");
        assert!(read(&text).unwrap_err().contains("XML"));
        let data = PAGE.replace("<netft>", "<netft><x><![CDATA[<cfgcpf>7</cfgcpf>]]></x>");
        assert_eq!(read(&data).unwrap().scale.per_newton, 1e6);
    }

    #[test]
    fn pages_that_are_not_believed_say_why() {
        for (from, to, part) in [
            ("1000000", "1e-320", "netft.cfgcpf = 1e-320"),
            ("1000000", "0", "netft.cfgcpf = 0"),
            ("1000000", "1e999", "netft.cfgcpf"),
            ("Nmm", "furlong", "scfgtu = furlong"),
            ("3500", "0", "comrdtrate = 0"),
            ("3500", "70000", "comrdtrate = 70000"),
            ("</netft>", "", "not a whole page"),
            ("<netft>", "<netft><cfgcpf>5</cfgcpf>", "different values"),
        ] {
            let error = read(&PAGE.replacen(from, to, 1)).unwrap_err();
            assert!(error.contains(part), "{to}: {error}");
        }
        let deep = "<a>".repeat(5000) + &"</a>".repeat(5000);
        assert!(read(&deep).unwrap_err().contains("nested more than 16 deep"));
        let bomb = "<!DOCTYPE n [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]><netft>&b;</netft>";
        assert!(read(bomb).is_err());
        assert!(read("").is_err());
    }
}
