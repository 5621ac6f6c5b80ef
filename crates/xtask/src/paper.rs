//! Every command of docs/paper.md, run.

use std::fs;

use crate::tools;

/// Runs the commands of both lists into `target/paper`, and puts the picture of the end points into docs/images; true when each
/// ends with the exit code that the page says.
pub fn run() -> bool {
    let Ok(page) = fs::read_to_string(tools::root().join("docs/paper.md")) else {
        eprintln!("error: docs/paper.md cannot be read");
        return false;
    };
    if !tools::built() {
        return false;
    }
    let out = tools::root().join("target/paper");
    let _ = fs::remove_dir_all(&out);
    let lines =
        page.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next()).flat_map(str::lines);
    let mut failed = 0;
    for (i, line) in lines.enumerate() {
        let (command, code) = line.split_once('#').unwrap_or((line, "0"));
        // `0 > name` names the folder for later commands.
        let (code, name) = code.split_once('>').unwrap_or((code, ""));
        let code: Option<i32> = code.trim().parse().ok();
        let name = if name.trim().is_empty() { i.to_string() } else { name.trim().to_owned() };
        let folder = out.join(name).to_string_lossy().into_owned();
        let words: Vec<&str> =
            command.split_whitespace().skip(1).chain(["--out", &folder, "--quiet"]).collect();
        let ended = tools::wingbeat(&words).current_dir(tools::root()).status().ok().and_then(|s| s.code());
        let verdict = if ended == code && code.is_some() { "as said" } else { "NOT as said" };
        failed += usize::from(verdict != "as said");
        println!("{verdict}: exit code {ended:?}: {}", command.trim());
    }
    println!("{failed} commands of docs/paper.md did not end as it says");
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
