//! `wingbeat migrate` as a user meets it.

use std::fs;

use crate::{entries, scratch, wingbeat};

/// A scenario of then, with what a migration has to keep.
const THEN: &str = "# mine\nname = \"a\"\nstart = { velocity_m_s = [1.0, 0.0, 0.0], pitch_deg = -3.5 }   # 3.5 up\n\
    manoeuvre.pitch_deg = +0.0\n\n[plan.least_power]\npitch_deg = [-40.0, 5e0]  # negative is nose up\n";
const NOW: &str = "# mine\nname = \"a\"\nstart = { velocity_m_s = [1.0, 0.0, 0.0], nose_up_deg = 3.5 }   # 3.5 up\n\
    manoeuvre.nose_up_deg = 0.0\n\n[plan.least_power]\nnose_up_deg = [-5e0, 40.0]  # positive is nose up\n";
/// Draws of then and their calibration.
const OTHERS: [(&str, &str); 4] = [
    (
        "[[draws]]\nkey = \"start.pitch_deg\"\nlow = -4.0\nhigh = 1.0\n[[draws]]\nkey = \"start.pitch_deg\"\nvalues = [1, -2, 0x1_0]\n",
        "[[draws]]\nkey = \"start.nose_up_deg\"\nlow = -1.0\nhigh = 4.0\n[[draws]]\nkey = \"start.nose_up_deg\"\nvalues = [-1, 2, -16]\n",
    ),
    (
        "[[parameters]]\nname = \"surfaces.wing.section_slope\"\n[numbers]\n\"links.a.series.x\" = 1\n",
        "[[parameters]]\nname = \"surfaces.wing.lift_slope_per_rad\"\n[numbers]\n\"links.a.driven.x\" = 1\n",
    ),
    // Overrides: numbers, ranges, tables, keys with indices and spaces, and what only looks like one.
    (
        "[truth]\nset = [\"start.pitch_deg=-15\", 'aero.law=lev', \"plan.least_power.pitch_deg = [-40.0, 5]\", 'start={ pitch_deg = 2 }']\n\
         [search]\nflights = [['runs[0].set=[\"start.pitch_deg=+3e0\"]'], [\"links.a.series.x = 2\", \"start.my_pitch_deg=1\"]]\n",
        "[truth]\nset = [\"start.nose_up_deg=15\", 'aero.law=lev', \"plan.least_power.nose_up_deg = [-5, 40.0]\", 'start={ nose_up_deg = -2 }']\n\
         [search]\nflights = [['runs[0].set=[\"start.nose_up_deg=-3e0\"]'], [\"links.a.driven.x = 2\", \"start.my_pitch_deg=1\"]]\n",
    ),
    // Other keys of a draw keep their values: one of two that turn alone turns its sign.
    (
        "[[draws]]\nkey = \"start.pitch_deg\"\nlow = -4.0\nhigh = 1.0\nstart = -2\nalso = [\"a.b\", '-a.c', \"-goal.pitch_deg\", \"goal.pitch_deg\"]\n\
         [[draws]]\nkey = \"a.d\"\nlow = -4.0\nhigh = 1.0\nalso = [\"pitch_deg\", \"-start.pitch_deg\", \"a.e\", \"-a.series.x\"]\n",
        "[[draws]]\nkey = \"start.nose_up_deg\"\nlow = -1.0\nhigh = 4.0\nstart = 2\nalso = [\"-a.b\", 'a.c', \"-goal.nose_up_deg\", \"goal.nose_up_deg\"]\n\
         [[draws]]\nkey = \"a.d\"\nlow = -4.0\nhigh = 1.0\nalso = [\"-nose_up_deg\", \"start.nose_up_deg\", \"a.e\", \"-a.driven.x\"]\n",
    ),
];

#[test]
fn documents_of_then_get_the_names_of_today_and_keep_all_else() {
    let folder = scratch("migrate");
    for (k, (then, now)) in [(THEN, NOW)].into_iter().chain(OTHERS).enumerate() {
        let name = format!("{k}.toml");
        fs::write(folder.join(&name), then).unwrap();
        let output = wingbeat(&folder, &["migrate", "--dry-run", &name]);
        assert!(output.status.success(), "{output:?}");
        assert_eq!(fs::read_to_string(folder.join(&name)).unwrap(), then);
        let output = wingbeat(&folder, &["migrate", &name]);
        let told = String::from_utf8(output.stdout).unwrap();
        assert!(told.contains(":3: ") && told.ends_with("written\n") || k >= 2, "{told}");
        assert_eq!(fs::read_to_string(folder.join(&name)).unwrap(), now);
        let output = wingbeat(&folder, &["migrate", &name]);
        assert_eq!(String::from_utf8(output.stdout).unwrap(), format!("{name}: nothing to change\n"));
    }
    assert_eq!(entries(&folder), ["0.toml", "1.toml", "2.toml", "3.toml", "4.toml"]);
}

#[test]
fn nothing_is_rewritten_where_one_file_is_wrong() {
    let folder = scratch("migrate-wrong");
    fs::write(folder.join("a.toml"), THEN).unwrap();
    fs::write(folder.join("b.toml"), "name = \n").unwrap();
    for (file, said) in [("b.toml", "b.toml:1: not TOML"), ("none.toml", "none.toml"), (".", "")] {
        let output = wingbeat(&folder, &["migrate", "a.toml", file]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(said), "{message}");
    }
    assert_eq!(fs::read_to_string(folder.join("a.toml")).unwrap(), THEN);
    assert_eq!(entries(&folder), ["a.toml", "b.toml"]);
}

#[test]
fn a_former_key_is_refused_with_the_line_of_today() {
    let folder = scratch("migrate-refused");
    let output = wingbeat(&folder, &["new", "scenario"]);
    assert!(output.status.success(), "{output:?}");
    let text = fs::read_to_string(folder.join("scenario.toml")).unwrap();
    let then = text.replacen("nose_up_deg = 15.0", "pitch_deg = -15.0", 1);
    assert_ne!(text, then);
    fs::write(folder.join("scenario.toml"), then).unwrap();
    let output = wingbeat(&folder, &["fly", "scenario.toml"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    let said = "pitch_deg = -15.0: write nose_up_deg = 15.0, positive is nose up; `wingbeat migrate FILE` rewrites a file";
    assert!(message.contains(said) && message.contains("scenario.toml:"), "{message}");
    assert!(wingbeat(&folder, &["migrate", "scenario.toml"]).status.success());
    assert_eq!(fs::read_to_string(folder.join("scenario.toml")).unwrap(), text);
}
