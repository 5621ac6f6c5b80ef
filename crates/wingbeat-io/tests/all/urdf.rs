//! Arms from URDF files.

use wingbeat::rig::arm::ArmConfig;
use wingbeat::rig::rotation_vector;
use wingbeat_io::urdf::tree::UrdfRobot;
use wingbeat_io::{parse_urdf, urdf_as_toml};

/// The chain of an arm as URDF text, to be read back.
fn urdf_of(arm: &ArmConfig) -> String {
    let mut text = String::from("<robot name=\"arm\"><link name=\"l0\"/>");
    let triple = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    for (i, j) in arm.joints.iter().enumerate() {
        let kind = if j.low_rad.is_some() { "revolute" } else { "continuous" };
        text += &format!(
            "<link name=\"l{}\"/><joint name=\"{}\" type=\"{kind}\"><origin xyz=\"{}\" rpy=\"{}\"/>\
             <parent link=\"l{i}\"/><child link=\"l{}\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"{}\" upper=\"{}\" effort=\"9\" velocity=\"1.2\"/></joint>",
            i + 1,
            j.name,
            triple(j.xyz_m),
            triple(j.rpy_rad),
            i + 1,
            j.low_rad.unwrap_or(0.0),
            j.high_rad.unwrap_or(0.0),
        );
    }
    let n = arm.joints.len();
    text += &format!(
        "<link name=\"tool\"/><joint name=\"fix\" type=\"fixed\"><origin xyz=\"{}\" rpy=\"{}\"/>\
         <parent link=\"l{n}\"/><child link=\"tool\"/></joint></robot>",
        triple(arm.tool.xyz_m),
        triple(arm.tool.rpy_rad)
    );
    text
}

#[test]
fn the_kinova_comes_back_from_its_urdf() {
    let known = ArmConfig::kinova_gen3();
    let read = parse_urdf(&urdf_of(&known), None).unwrap();
    let (a, b) = (known.build().unwrap(), read.build().unwrap());
    let q = [0.3, -0.8, 1.2, 2.0, -0.4, 1.0];
    let (x, y) = (a.tool_pose(&q), b.tool_pose(&q));
    assert!((x.origin - y.origin).norm() < 1e-12);
    assert!(rotation_vector(&(x.rotation * y.rotation.transpose())).norm() < 1e-12);
    assert_eq!(read.profile("urdf").unwrap().velocity, vec![1.2; 6]);
}

#[test]
fn wrong_files_are_explained() {
    assert!(parse_urdf("<xml/>", None).unwrap_err().contains("no <robot>"));
    let fork = "<robot name='x'><link name='a'/><link name='b'/><link name='c'/>\
        <joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\
        <joint name='k' type='fixed'><parent link='a'/><child link='c'/></joint></robot>";
    assert!(parse_urdf(fork, None).unwrap_err().contains("b, c"));
    let cut = urdf_of(&ArmConfig::kinova_gen3());
    assert!(parse_urdf(&cut[..cut.len() / 2], None).unwrap_err().contains("not a URDF"));
    let deep = format!("<robot name='x'>{}{}</robot>", "<a>".repeat(9999), "</a>".repeat(9999));
    assert!(parse_urdf(&deep, None).unwrap_err().contains("nested more than 256 deep"));
    let disguised = format!("<robot name='x'>{}{}</robot>", "<a>/>".repeat(50_000), "</a>".repeat(50_000));
    assert!(parse_urdf(&disguised, None).unwrap_err().contains("nested more than 256 deep"));
    for (wrong, said) in [
        ("<!DOCTYPE robot [<!ENTITY a 'b'>]><robot name='&a;'/>", "DOCTYPE"),
        ("<robot name='x'>\n<link/></robot>", "line 2: <link> without name"),
        ("<robot><joint name='j' type='ball'/></robot>", "type=\"ball\""),
        (
            "<robot><link name='a'/><joint name='j' type='fixed'><parent link='a'/></joint></robot>",
            "joint j: it needs",
        ),
        (
            "<robot><link name='a'><inertial><mass value='1 kg'/></inertial></link></robot>",
            "<mass value=\"1 kg\">",
        ),
        (
            "<robot><joint name='j' type='fixed'><origin xyz='0 nan 1'/></joint></robot>",
            "allowed is 3 finite numbers",
        ),
    ] {
        let error = parse_urdf(wrong, None).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
    // Texts, comments and what closes itself are no depth.
    let shallow = "<robot name='x'><!-- <a><a> --><link name='l'/><b x='/>'/><![CDATA[<d><d>]]></robot>";
    assert_eq!(UrdfRobot::read(shallow).unwrap().links.len(), 1);
    let many = format!("<robot name='x'>{}</robot>", "<link name='a'/>".repeat(5000));
    assert!(parse_urdf(&many, None).unwrap_err().contains("5000 links"));
}

#[test]
fn missing_limits_are_named_as_the_file_has_them() {
    let whole = urdf_of(&ArmConfig::kinova_gen3());
    let path = std::env::temp_dir().join(format!("wingbeat-urdf-{}.urdf", std::process::id()));
    let refused = |text: String| {
        std::fs::write(&path, text).unwrap();
        urdf_as_toml(&path, None).unwrap().unwrap_err()
    };
    let unlimited = refused(whole.replace(" velocity=\"1.2\"", " velocity=\"0\""));
    assert!(unlimited.contains("joint joint_1: <limit velocity="), "{unlimited}");
    let stuck = refused(whole.replace("upper=\"", "upper=\"-9"));
    assert!(stuck.contains("<limit lower=") && stuck.contains("leaves it no room"), "{stuck}");
    std::fs::remove_file(path).unwrap();
}
