//! Every command behind the pages on the paper, run and judged by what comes out.

use std::fs;
use std::path::Path;

use crate::tools;

/// The commands, with what is to come out.
const LIST: &str = "validation/paper/commands.txt";

/// A line of a list: `wingbeat ...   # 0 > name | key low high | key low high`.
struct PaperCommand<'a> {
    words: Vec<&'a str>,
    /// Exit code; 0 where the line says none.
    code: Option<i32>,
    /// Folder that later commands name; empty where the line says none.
    name: &'a str,
    outcomes: Vec<ExpectedNumber<'a>>,
}

/// A number of `summary.json` and the range in which it lies.
struct ExpectedNumber<'a> {
    key: &'a str,
    range: Option<[f64; 2]>,
}

impl<'a> PaperCommand<'a> {
    fn read(line: &'a str) -> Self {
        let (command, end) = line.split_once('#').unwrap_or((line, "0"));
        let mut parts = end.split('|');
        let first = parts.next().unwrap_or_default();
        let (code, name) = first.split_once('>').unwrap_or((first, ""));
        Self {
            // Brackets stand in quotes, which a shell takes away.
            words: command.split_whitespace().skip(1).map(|word| word.trim_matches('\'')).collect(),
            code: code.trim().parse().ok(),
            name: name.trim(),
            outcomes: parts.map(ExpectedNumber::read).collect(),
        }
    }

    /// Runs it into a folder below `out`; what did not come out as the line says.
    fn run(&self, i: usize, out: &Path) -> Vec<String> {
        let name = if self.name.is_empty() { i.to_string() } else { self.name.to_owned() };
        let folder = out.join(name);
        let place = folder.to_string_lossy().into_owned();
        let words: Vec<&str> = self.words.iter().copied().chain(["--out", &place, "--quiet"]).collect();
        let ended = tools::wingbeat(&words).current_dir(tools::root()).status().ok().and_then(|s| s.code());
        let mut wrong = Vec::new();
        if ended != self.code || self.code.is_none() {
            wrong.push(format!("exit code {ended:?}, not {:?}", self.code));
        }
        if !self.outcomes.is_empty() {
            let summary = fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
            let summary = serde_json::from_str(&summary).unwrap_or_default();
            wrong.extend(self.outcomes.iter().filter_map(|outcome| outcome.missed(&summary)));
        }
        wrong
    }
}

impl<'a> ExpectedNumber<'a> {
    fn read(text: &'a str) -> Self {
        let words: Vec<&str> = text.split_whitespace().collect();
        let [key, low, high] = words[..] else { return Self { key: text.trim(), range: None } };
        let range = low.parse().ok().zip(high.parse().ok()).map(|(low, high)| [low, high]);
        Self { key, range }
    }

    /// What is wrong with it in a summary.
    fn missed(&self, summary: &serde_json::Value) -> Option<String> {
        let Some([low, high]) = self.range else {
            return Some(format!("`{}` is not a key with its two bounds", self.key));
        };
        match summary[self.key].as_f64() {
            Some(value) if (low..=high).contains(&value) => None,
            Some(value) => Some(format!("{} is {value:.4}, not {low} to {high}", self.key)),
            None => Some(format!("the summary has no number {}", self.key)),
        }
    }
}

/// Runs all commands into `target/paper`, and puts the picture of the end points into docs/images; true when each
/// ends with the exit code and the numbers that the list says.
pub fn run() -> bool {
    let text = match fs::read_to_string(tools::root().join(LIST)) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: {LIST}: {error}");
            return false;
        }
    };
    if !tools::built() {
        return false;
    }
    let out = tools::root().join("target/paper");
    let _ = fs::remove_dir_all(&out);
    let lines = text.lines().filter(|line| line.starts_with("wingbeat "));
    let (mut failed, mut judged) = (0, 0);
    for (i, line) in lines.enumerate() {
        let command = PaperCommand::read(line);
        let wrong = command.run(i, &out);
        failed += usize::from(!wrong.is_empty());
        judged += command.outcomes.len();
        let verdict = if wrong.is_empty() { "as said" } else { "NOT as said" };
        println!("{verdict}: {}", command.words.join(" "));
        wrong.iter().for_each(|wrong| println!("    {wrong}"));
    }
    println!("{failed} commands did not end as the list says; {judged} numbers were compared");
    let picture = "end_points.png";
    let drawn = fs::copy(
        out.join("end_points/figures").join(picture),
        tools::root().join("docs/images").join(picture),
    );
    if let Err(error) = &drawn {
        eprintln!("error: {picture}: {error}");
    }
    failed == 0 && drawn.is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_code_folder_and_numbers() {
        let line = "wingbeat fly a.toml   # 3 > turn | roll_mean_deg 14 16 | pitch_mean_deg -17 -13";
        let command = PaperCommand::read(line);
        assert_eq!((command.code, command.name, command.words[1]), (Some(3), "turn", "a.toml"));
        let summary = serde_json::json!({ "roll_mean_deg": 15.5, "pitch_mean_deg": -12.0 });
        let missed: Vec<_> = command.outcomes.iter().map(|outcome| outcome.missed(&summary)).collect();
        assert!(missed[0].is_none() && missed[1].as_ref().is_some_and(|text| text.contains("-12")));
        assert!(ExpectedNumber::read(" yaw_change_deg 0 1 ").missed(&summary).is_some());
        assert!(ExpectedNumber::read(" roll_mean_deg 14").missed(&summary).is_some());
        let plain = PaperCommand::read("wingbeat validate --only paper");
        assert_eq!((plain.code, plain.name, plain.outcomes.len()), (Some(0), "", 0));
    }
}
