//! Links and joints as they stand in a URDF file (<http://wiki.ros.org/urdf/XML>).

use xml::attribute::OwnedAttribute;
use xml::common::Position;
use xml::reader::{ParserConfig2, XmlEvent};

/// Longest attribute or text, bytes.
const LONGEST: usize = 1 << 16;
/// Most attributes of an element.
const MOST_ATTRIBUTES: usize = 64;
/// Deepest nesting; links and joints need 4.
const DEEPEST: usize = 256;
/// Most links and joints: a robot of several hundred is a large one.
const MOST: usize = 4096;

/// A robot as its file describes it.
#[derive(Clone, Debug, Default)]
pub struct UrdfRobot {
    /// Its name.
    pub name: String,
    /// Its links in the order of the file.
    pub links: Vec<UrdfLink>,
    /// Its joints in the order of the file.
    pub joints: Vec<UrdfJoint>,
}

/// A frame in another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UrdfOrigin {
    /// Place, m.
    pub xyz: [f64; 3],
    /// Roll, pitch and yaw about the fixed axes of the other, rad.
    pub rpy: [f64; 3],
}

/// A rigid body; without `<inertial>` it has no mass.
#[derive(Clone, Debug, Default)]
pub struct UrdfLink {
    /// Its name.
    pub name: String,
    /// Principal frame at the centre of mass, in the link's.
    pub origin: UrdfOrigin,
    /// Mass, kg.
    pub mass: f64,
    /// xx, xy, xz, yy, yz, zz about the centre of mass in that frame, kg m2.
    pub inertia: [f64; 6],
}

/// How the child of a joint moves in its parent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the words of URDF")]
pub enum JointType {
    #[default]
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Floating,
    Planar,
    Spherical,
}

/// A joint between two links.
#[derive(Clone, Debug, Default)]
pub struct UrdfJoint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub joint_type: JointType,
    /// Its frame in that of the parent.
    pub origin: UrdfOrigin,
    /// Name of the parent link.
    pub parent: String,
    /// Name of the child link.
    pub child: String,
    /// Axis in the frame of the joint, dimensionless.
    pub axis: [f64; 3],
    /// Least place, rad or m.
    pub lower: f64,
    /// Largest place, rad or m.
    pub upper: f64,
    /// Largest moment or force, N m or N; 0 where none is given.
    pub effort: f64,
    /// Largest speed, rad/s or m/s; 0 where none is given.
    pub velocity: f64,
    /// Whether it follows another joint.
    pub mimics: bool,
}

/// Attributes of an element.
struct UrdfElement<'a> {
    name: &'a str,
    attributes: &'a [OwnedAttribute],
}

impl UrdfElement<'_> {
    fn text(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.name.local_name == name).map(|a| a.value.trim())
    }

    fn needed(&self, name: &str) -> Result<String, String> {
        let text = self.text(name).filter(|text| !text.is_empty());
        text.map(str::to_owned).ok_or_else(|| format!("<{}> without {name}", self.name))
    }

    /// `N` numbers, those given where the attribute is missing.
    fn numbers<const N: usize>(&self, name: &str, missing: [f64; N]) -> Result<[f64; N], String> {
        let Some(text) = self.text(name) else { return Ok(missing) };
        let numbers = text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()));
        let numbers: Option<Vec<f64>> = numbers.collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        let allowed = if N == 1 { "a finite number".into() } else { format!("{N} finite numbers") };
        numbers.ok_or_else(|| format!("<{} {name}=\"{text:.60}\">: allowed is {allowed}", self.name))
    }

    fn number(&self, name: &str) -> Result<f64, String> {
        self.numbers(name, [0.0]).map(|[number]| number)
    }

    fn origin(&self) -> Result<UrdfOrigin, String> {
        Ok(UrdfOrigin { xyz: self.numbers("xyz", [0.0; 3])?, rpy: self.numbers("rpy", [0.0; 3])? })
    }

    fn joint_type(&self) -> Result<JointType, String> {
        Ok(match self.needed("type")?.as_str() {
            "fixed" => JointType::Fixed,
            "revolute" => JointType::Revolute,
            "continuous" => JointType::Continuous,
            "prismatic" => JointType::Prismatic,
            "floating" => JointType::Floating,
            "planar" => JointType::Planar,
            "spherical" => JointType::Spherical,
            other => return Err(format!("<joint type=\"{other:.60}\">: no type of a joint")),
        })
    }
}

impl UrdfRobot {
    /// Reads the text of a file. Elements beside links and joints (`<visual>`, `<transmission>`) are passed over.
    ///
    /// # Errors
    /// By line: what is not well-formed, has a document type (whose entities may grow without end), nests elements deeper
    /// than 256, has more than 4096 links or joints, or lacks what a joint needs.
    pub fn read(text: &str) -> Result<Self, String> {
        if text.contains("<!DOCTYPE") {
            return Err("a document type (<!DOCTYPE) is not read".into());
        }
        let config = ParserConfig2::new()
            .max_attributes(MOST_ATTRIBUTES)
            .max_attribute_length(LONGEST)
            .max_data_length(LONGEST)
            .max_entity_expansion_depth(1);
        let mut reader = config.create_reader(text.as_bytes());
        let (mut robot, mut path) = (Self::default(), Vec::new());
        loop {
            match reader.next().map_err(|error| error.to_string())? {
                XmlEvent::StartElement { name, attributes, .. } => {
                    path.push(name.local_name);
                    if path.len() > DEEPEST {
                        return Err(format!("elements nested more than {DEEPEST} deep"));
                    }
                    let element = UrdfElement { name: &path[path.len() - 1], attributes: &attributes };
                    let names: Vec<&str> = path.iter().take(5).map(String::as_str).collect();
                    let line = reader.position().row + 1;
                    robot.take(&names, &element).map_err(|what| format!("line {line}: {what}"))?;
                }
                XmlEvent::EndElement { .. } => {
                    path.pop();
                }
                XmlEvent::EndDocument => break,
                _ => {}
            }
        }
        let (links, joints) = (robot.links.len(), robot.joints.len());
        if links.max(joints) > MOST {
            return Err(format!("{links} links and {joints} joints; read are at most {MOST} of each"));
        }
        let loose = robot.joints.iter().find(|joint| joint.parent.is_empty() || joint.child.is_empty());
        match loose {
            Some(joint) => Err(format!("joint {}: it needs <parent link> and <child link>", joint.name)),
            None => Ok(robot),
        }
    }

    /// Takes in what an element says, by the names from the root to it.
    fn take(&mut self, path: &[&str], element: &UrdfElement<'_>) -> Result<(), String> {
        match (path, self.links.last_mut(), self.joints.last_mut()) {
            (["robot"], ..) => self.name = element.text("name").unwrap_or_default().into(),
            (["robot", "link"], ..) => {
                self.links.push(UrdfLink { name: element.needed("name")?, ..UrdfLink::default() });
            }
            (["robot", "link", "inertial", "origin"], Some(link), _) => link.origin = element.origin()?,
            (["robot", "link", "inertial", "mass"], Some(link), _) => link.mass = element.number("value")?,
            (["robot", "link", "inertial", "inertia"], Some(link), _) => {
                for (value, name) in link.inertia.iter_mut().zip(["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]) {
                    *value = element.number(name)?;
                }
            }
            (["robot", "joint"], ..) => self.joints.push(UrdfJoint {
                name: element.needed("name")?,
                joint_type: element.joint_type()?,
                axis: [1.0, 0.0, 0.0],
                ..UrdfJoint::default()
            }),
            (["robot", "joint", part], _, Some(joint)) => joint.take(part, element)?,
            _ => {}
        }
        Ok(())
    }
}

impl UrdfJoint {
    fn take(&mut self, part: &str, element: &UrdfElement<'_>) -> Result<(), String> {
        match part {
            "origin" => self.origin = element.origin()?,
            "parent" => self.parent = element.needed("link")?,
            "child" => self.child = element.needed("link")?,
            "axis" => self.axis = element.numbers("xyz", self.axis)?,
            "limit" => {
                self.lower = element.number("lower")?;
                self.upper = element.number("upper")?;
                self.effort = element.number("effort")?;
                self.velocity = element.number("velocity")?;
            }
            "mimic" => self.mimics = true,
            _ => {}
        }
        Ok(())
    }
}
