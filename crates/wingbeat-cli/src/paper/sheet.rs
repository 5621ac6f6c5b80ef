//! The sheet: one HTML file with all figures inside.

use wingbeat::judge::Verdict;

use super::PaperStep;
use super::figures::PaperFigures;
use super::statements::Statement;

const HEAD: &str = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>The paper by our numbers</title>\n\
<style>\nbody { font: 16px/1.45 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222 }\n\
table { border-collapse: collapse; width: 100%; margin: 1em 0 }\nth, td { text-align: left; vertical-align: top; padding: .3em .6em; \
border-bottom: 1px solid #ddd }\nfigure { margin: 2em 0 }\nfigure svg { width: 100%; height: auto }\nfigcaption { color: #444 }\n\
code { font-size: 90% }\n.reproduced { color: #00664b }\n.missed, .refuted { color: #a03c00 }\n@media print { figure { break-inside: avoid } }\n\
</style>\n</head>\n<body>\n";

const INTRODUCTION: &str = "<h1>The paper by our numbers</h1>\n<p>The paper is Gupta, Sihite &amp; Ramezani, <em>Modeling and Controls of \
Fluid-Structure Interactions (FSI) in Dynamic Morphing Flight</em> (<a href=\"https://arxiv.org/abs/2406.13039\">arXiv 2406.13039</a>).\n\
Its pictures are not ours to copy: this sheet gives in words and numbers what they show, beside what came out here.\n\
Pitch counts nose up here; roll 15 deg is right wing down.\n\
Where a run is a fit, it proves nothing; each row says so. The page docs/paper.md has every statement with how we read it.</p>\n";

/// The whole sheet.
pub fn html(
    statements: &[Statement],
    steps: &[PaperStep],
    drawn: &PaperFigures,
    verdict: &Verdict,
) -> String {
    let mut text = String::from(HEAD);
    text += INTRODUCTION;
    text += "<h2>Statements</h2>\n<table>\n<tr><th>statement</th><th>the paper</th><th>here</th><th>of</th><th>verdict</th></tr>\n";
    for Statement { what, paper, here, of, outcome, note } in statements {
        let [paper, here] = [paper, here].map(|cell| escaped(cell));
        let note = if note.is_empty() { String::new() } else { format!("<br><small>{note}</small>") };
        let words = outcome.words();
        let class = words.replace(' ', "-");
        text += &format!(
            "<tr><td>{what}</td><td>{paper}</td><td>{here}{note}</td><td>{of}</td><td class=\"{class}\">{words}</td></tr>\n"
        );
    }
    text += "</table>\n<h2>Figures</h2>\n";
    for (number, (name, caption, svg)) in drawn.shown().enumerate() {
        let inside = svg.find("<svg").map_or("", |at| &svg[at..]);
        text += &format!(
            "<figure id=\"{name}\">\n{}\n<figcaption>{}. {caption}</figcaption>\n</figure>\n",
            apart(inside, name),
            number + 1
        );
    }
    text += "<h2>Runs</h2>\n<table>\n<tr><th>command</th><th>folder</th><th>status</th></tr>\n";
    for PaperStep { command, folder, status, reason } in steps {
        let reason = reason.as_deref().map_or(String::new(), |reason| format!(": {}", escaped(reason)));
        text +=
            &format!("<tr><td><code>{command}</code></td><td>{folder}</td><td>{status}{reason}</td></tr>\n");
    }
    text += &format!("</table>\n<p>This sheet is <strong>{}</strong>", verdict.status.name());
    text += &verdict.reason.as_deref().map_or(String::new(), |reason| format!(": {}", escaped(reason)));
    text + ".</p>\n</body>\n</html>\n"
}

/// The picture with names of its own inside, so that clips of one figure are not taken for those of another.
fn apart(svg: &str, name: &str) -> String {
    svg.replace(" id=\"", &format!(" id=\"{name}-")).replace("url(#", &format!("url(#{name}-"))
}

/// Text as HTML has it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
