//! The page of the comparisons and its figures name what is compared.

use std::path::Path;
use wingbeat_validate::figures::{PICTURES, SLOW_PICTURES};
use wingbeat_validate::{PagePiece, below, cases, pieces, slow_cases};

fn words() -> impl Iterator<Item = String> {
    pieces().filter_map(|piece| match piece {
        PagePiece::Words(words) => Some(words.replace("](figures/", "](images/validation/")),
        PagePiece::Place(_) => None,
    })
}

#[test]
fn the_page_has_every_comparison_and_every_figure() {
    let places = pieces().filter_map(|piece| match piece {
        PagePiece::Place(place) => place.strip_prefix("rows "),
        PagePiece::Words(_) => None,
    });
    let named: Vec<&str> = places.flat_map(|names| names.split(' ')).collect();
    for case in cases() {
        assert!(named.iter().any(|name| below(case.id, name)), "{} is not on the page", case.id);
    }
    let text: String = words().collect();
    for picture in PICTURES {
        assert!(text.contains(&format!("](images/validation/{}.png)", picture.name)), "{}", picture.name);
    }
    assert_eq!(text.matches("](images/validation/").count(), PICTURES.len());
}

/// Only the words: the numbers are compared where the rows are computed anyway.
#[test]
fn the_page_in_docs_is_current() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let page = std::fs::read_to_string(docs.join("validation.md")).unwrap_or_default();
    let mut rest = page.as_str();
    for words in words() {
        let at = rest.find(&words);
        assert!(at.is_some(), "docs/validation.md is stale: run `cargo xtask docs`; it lacks {words:?}");
        rest = &rest[at.unwrap_or(0) + words.len()..];
    }
    for picture in PICTURES {
        let path = docs.join("images/validation").join(picture.name).with_extension("png");
        assert!(path.exists(), "no {}: run `cargo xtask docs`", path.display());
    }
}

#[test]
fn every_figure_shows_cases_that_exist() {
    let cases = [cases(), slow_cases()].concat();
    for picture in PICTURES.iter().chain(SLOW_PICTURES) {
        for id in picture.cases {
            assert!(cases.iter().any(|case| case.id == *id), "{}: no case {id}", picture.name);
        }
    }
}
