//! The book: built by mdbook, and every link of its pages followed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::tools;

/// The version of mdbook that builds the book.
const VERSION: &str = "0.5.4";

/// Builds the book into target/book and follows its links; true when all lead somewhere.
pub fn build() -> bool {
    let Some(mdbook) =
        tools::installed("mdbook", VERSION, &["--no-default-features", "--features", "search"])
    else {
        return false;
    };
    let mut build = Command::new(mdbook);
    build.arg("build").arg(tools::root().join("docs"));
    if !tools::succeeds(build) {
        return false;
    }
    let book = tools::root().join("target/book");
    let pages = pages(&book);
    let broken: Vec<String> = pages.iter().flat_map(|page| broken(&book, page)).collect();
    println!("{} pages in {}; {} broken links", pages.len(), book.display(), broken.len());
    broken.iter().for_each(|link| println!("    {link}"));
    broken.is_empty() && pages.len() > 30
}

/// The pages of the book but the one that holds all, and that of what is not found.
fn pages(book: &Path) -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![book.to_path_buf()], Vec::new());
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir(folder) else { continue };
        for path in entries.filter_map(Result::ok).map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "html")
                && !path.ends_with("print.html")
                && !path.ends_with("404.html")
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The links of a page that lead nowhere.
fn broken(book: &Path, page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).unwrap_or_default();
    let shown = page.strip_prefix(book).unwrap_or(page).display().to_string();
    let leads = |link: &String| {
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let target = if file.is_empty() { page.to_path_buf() } else { page.with_file_name("").join(file) };
        let holds = |target: &Path| {
            let text = fs::read_to_string(target).unwrap_or_default();
            text.contains(&format!("id=\"{anchor}\"")) || text.contains(&format!("name=\"{anchor}\""))
        };
        target.exists() && (anchor.is_empty() || holds(&target))
    };
    links(&text).into_iter().filter(|link| !leads(link)).map(|link| format!("{shown}: {link}")).collect()
}

/// What the page names of the book: values of `href` and `src` without an address of their own.
fn links(text: &str) -> Vec<String> {
    let of = |attribute: &str| {
        text.split(attribute)
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let outside = |link: &String| {
        link.contains("://")
            || ["mailto:", "data:", "javascript:"].iter().any(|start| link.starts_with(start))
    };
    [of(" href=\""), of(" src=\"")]
        .concat()
        .into_iter()
        .filter(|link| !link.is_empty() && !outside(link))
        .collect()
}

#[test]
fn links_of_a_page_are_read() {
    let page = "<a href=\"b.html#c\">x</a> <a class=\"y\" href=\"https://a.b\">z</a> <img src=\"i.png\">";
    assert_eq!(links(page), ["b.html#c", "i.png"]);
}
