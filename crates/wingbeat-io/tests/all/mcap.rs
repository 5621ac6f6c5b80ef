//! Recordings of ROS 2 with several, empty, late and hostile topics.

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use wingbeat::rig::process::InputSpec;
use wingbeat_io::samples::{ImportedRecord, MCAP_MAGIC, read_samples};

const WRENCH: &str = "geometry_msgs/msg/WrenchStamped";
const JOINTS: &str = "sensor_msgs/msg/JointState";
/// Time between two wrenches, ns.
const STEP: u64 = 10_000_000;

/// A recording while it is written: no chunk, no index.
struct Bag(Vec<u8>);

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

/// A message in CDR.
struct Message(Vec<u8>);

impl Message {
    fn of(time: u64) -> Self {
        let mut message = Self(vec![0, 1, 0, 0]);
        message.int((time / 1_000_000_000) as u32).int((time % 1_000_000_000) as u32).text("");
        message
    }

    fn pad(&mut self, size: usize) {
        while !(self.0.len() - 4).is_multiple_of(size) {
            self.0.push(0);
        }
    }

    fn int(&mut self, value: u32) -> &mut Self {
        self.pad(4);
        self.0.extend(value.to_le_bytes());
        self
    }

    fn text(&mut self, text: &str) -> &mut Self {
        self.int(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
        self
    }

    fn doubles(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.pad(8);
            self.0.extend(value.to_le_bytes());
        }
        self
    }
}

impl Bag {
    fn new() -> Self {
        let mut bag = Self(MCAP_MAGIC.to_vec());
        bag.record(1, &[0; 8]);
        bag
    }

    fn record(&mut self, code: u8, content: &[u8]) {
        self.0.push(code);
        self.0.extend((content.len() as u64).to_le_bytes());
        self.0.extend(content);
    }

    fn topic(&mut self, id: u16, name: &str, kind: &str) {
        let mut schema = (id + 1).to_le_bytes().to_vec();
        [kind, "ros2msg", ""].iter().for_each(|word| text(&mut schema, word));
        self.record(3, &schema);
        let mut channel = [id.to_le_bytes(), (id + 1).to_le_bytes()].concat();
        text(&mut channel, name);
        text(&mut channel, "cdr");
        channel.extend([0; 4]);
        self.record(4, &channel);
    }

    fn message(&mut self, id: u16, time: u64, message: &Message) {
        let mut content = id.to_le_bytes().to_vec();
        content.extend([0; 4]);
        content.extend([time, time].iter().flat_map(|time| time.to_le_bytes()));
        content.extend(&message.0);
        self.record(5, &content);
    }

    /// A second of wrenches of this force along x.
    fn wrenches(&mut self, id: u16, force: f64) {
        for time in (0..=100).map(|k| k * STEP) {
            let mut wrench = Message::of(time);
            wrench.doubles(&[force, 1.0, 2.0, 3.0, 4.0, 5.0]);
            self.message(id, time, &wrench);
        }
    }

    fn joints(&mut self, id: u16, time: u64, names: &[&str], positions: &[f64]) {
        let mut state = Message::of(time);
        state.int(names.len() as u32);
        names.iter().for_each(|name| {
            state.text(name);
        });
        state.int(positions.len() as u32).doubles(positions).int(0).int(0);
        self.message(id, time, &state);
    }

    fn read(mut self, name: &str, with: &str) -> Result<ImportedRecord, String> {
        self.record(15, &[0; 4]);
        self.0.extend(MCAP_MAGIC);
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::write(&path, &self.0).unwrap();
        let input: InputSpec = toml::from_str(with).unwrap();
        read_samples(&path, &input).and_then(|table| table.import(&input)).map_err(|error| error.to_string())
    }
}

fn force(imported: &ImportedRecord) -> f64 {
    imported.record.values("Fx").unwrap()[50]
}

#[test]
fn a_topic_without_messages_changes_no_names() {
    let mut bag = Bag::new();
    bag.topic(0, "/a/cell", WRENCH);
    bag.topic(1, "/b/wrench", WRENCH);
    bag.topic(2, "/c/joints", JOINTS);
    bag.wrenches(1, 7.0);
    let read = bag.read("one.mcap", "").unwrap();
    assert!(force(&read) == 7.0 && read.import.cautions.is_empty(), "{:?}", read.import);
    // Two others have messages, that of the cell has none.
    let mut bag = Bag::new();
    for (id, name) in ["/a/cell", "/b/wrench", "/c/tool"].iter().enumerate() {
        bag.topic(id as u16, name, WRENCH);
    }
    bag.wrenches(1, 7.0);
    bag.wrenches(2, 8.0);
    let error = bag.read("two.mcap", "").unwrap_err();
    assert!(error.contains("wrench_Fx") && error.contains("tool_Fx"), "{error}");
    let none = Bag::new().read("none.mcap", "").unwrap_err();
    assert!(none.contains("no messages of the type") && none.contains("found nothing"), "{none}");
}

#[test]
fn topics_of_one_last_part_are_told_apart_by_their_whole_names() {
    let bag = || {
        let mut bag = Bag::new();
        bag.topic(0, "/left/wrench", WRENCH);
        bag.topic(1, "/right/wrench", WRENCH);
        bag.wrenches(0, 7.0);
        bag.wrenches(1, 8.0);
        bag
    };
    for (side, there) in [("left", 7.0), ("right", 8.0)] {
        let columns = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
            .map(|channel| format!("columns.{channel} = \"/{side}/wrench_{channel}\"\n"));
        assert_eq!(force(&bag().read("sides.mcap", &columns.concat()).unwrap()), there);
    }
    let error = bag().read("sides.mcap", "").unwrap_err();
    assert!(error.contains("/left/wrench_Fx") && error.contains("/right/wrench_Fx"), "{error}");
}

#[test]
fn a_joint_with_the_name_of_a_force_gives_way_and_is_named() {
    let mut bag = Bag::new();
    bag.topic(0, "/joints", JOINTS);
    bag.topic(1, "/cell", WRENCH);
    bag.wrenches(1, 7.0);
    [0, 100 * STEP].iter().for_each(|time| bag.joints(0, *time, &["Fx", "q1"], &[100.0, 0.5]));
    let read = bag.read("joint.mcap", "").unwrap();
    assert_eq!((force(&read), read.record.values("q1").unwrap()[50]), (7.0, 0.5));
    assert!(read.import.cautions[0].contains("left out: Fx of /joints"), "{:?}", read.import.cautions);
}

#[test]
fn joints_that_come_late_and_slowly_leave_no_gaps() {
    let bag = |from: u64, to: u64| {
        let mut bag = Bag::new();
        bag.topic(0, "/cell", WRENCH);
        bag.topic(1, "/joints", JOINTS);
        bag.wrenches(0, 7.0);
        // Before the first position there are messages without one.
        bag.joints(1, 0, &[], &[]);
        (from..=to)
            .step_by(7)
            .for_each(|k| bag.joints(1, k * STEP, &["q1"], &[k as f64 * STEP as f64 * 1e-9]));
        bag
    };
    let read = bag(13, 83).read("late.mcap", "").unwrap();
    let [t, q] = ["t", "q1"].map(|name| read.record.values(name).unwrap());
    assert!(t.len() == 71 && (t[0] - 0.13).abs() < 1e-12, "{} from {}", t.len(), t[0]);
    assert!(t.iter().zip(q).all(|(t, q)| (t - q).abs() < 1e-12), "{q:?}");
    let said = "71 of 101 samples of /cell are used: /joints begins at 0.130 s, /joints ends at 0.830 s";
    assert_eq!(read.import.cautions, [said]);
    assert!(bag(0, 105).read("whole.mcap", "").unwrap().import.cautions.is_empty());
    let error = bag(200, 300).read("never.mcap", "").unwrap_err();
    assert!(
        error.contains("no sample of /cell lies where all topics have messages: /joints begins"),
        "{error}"
    );
}

#[test]
fn many_names_after_many_messages_without_any_are_refused_at_once() {
    let mut bag = Bag::new();
    bag.topic(0, "/cell", WRENCH);
    bag.topic(1, "/joints", JOINTS);
    bag.wrenches(0, 7.0);
    (0..60_000).for_each(|k| bag.joints(1, k, &[], &[]));
    let names: Vec<String> = (0..60_000).map(|k| format!("j{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    bag.joints(1, 60_000, &names, &vec![0.0; names.len()]);
    let began = Instant::now();
    let error = bag.read("many.mcap", "").unwrap_err();
    assert!(error.contains("topic /joints: a list of 60000; read are at most 4096"), "{error}");
    assert!(began.elapsed().as_secs_f64() < 10.0, "{:?}", began.elapsed());
}
