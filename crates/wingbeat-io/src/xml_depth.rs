//! Whether a text is XML that a parser which keeps it whole can bear.

use xml::reader::{ParserConfig2, XmlEvent};

/// Longest attribute or text, bytes.
const LONGEST: usize = 1 << 16;
/// Most attributes of an element.
const MOST_ATTRIBUTES: usize = 64;

/// Refuses what is not well-formed, has a document type (whose entities may grow without end), or nests elements
/// deeper than `deepest`.
pub fn check(text: &str, deepest: usize) -> Result<(), String> {
    let config = ParserConfig2::new()
        .max_attributes(MOST_ATTRIBUTES)
        .max_attribute_length(LONGEST)
        .max_data_length(LONGEST)
        .max_entity_expansion_depth(1);
    if text.contains("<!DOCTYPE") {
        return Err("a document type (<!DOCTYPE) is not read".into());
    }
    let mut depth = 0;
    for event in config.create_reader(text.as_bytes()) {
        match event.map_err(|error| error.to_string())? {
            XmlEvent::StartElement { .. } => depth += 1,
            XmlEvent::EndElement { .. } => depth -= 1,
            _ => {}
        }
        if depth > deepest {
            return Err(format!("elements nested more than {deepest} deep"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_parser_counts_is_depth() {
        assert_eq!(check("<r><!-- <a><a><a> --><b x='/>'/><c><![CDATA[<d><d>]]></c></r>", 2), Ok(()));
        // The text `/>` behind a tag does not close it.
        let deep = format!("<r>{}{}</r>", "<a>/>".repeat(99), "</a>".repeat(99));
        assert!(check(&deep, 99).unwrap_err().contains("more than 99 deep"));
        assert_eq!(check(&deep, 100), Ok(()));
        assert!(check("<!DOCTYPE r [<!ENTITY a 'b'>]><r>&a;</r>", 9).unwrap_err().contains("DOCTYPE"));
        assert!(check("<r><a></r>", 9).is_err() && check("", 9).is_err());
    }
}
