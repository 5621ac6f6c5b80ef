//! From the tree of a document to a type of the library: every complaint carries its path, and all are collected.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::de::value::StrDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, Unexpected,
    VariantAccess, Visitor,
};
use serde::{Deserializer, forward_to_deserialize_any};
use toml::Spanned;
use toml::de::DeValue;

use super::placeholder::Placeholder;
use super::tree::dotted;

/// Methods for a type that any value is asked for: a placeholder answers where one stands.
macro_rules! typed {
    ($($method:ident)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
            if self.replaced() { Placeholder.$method(visitor) } else { self.deserialize_any(visitor) }
        }
    )*};
}

/// Most complaints of one document.
const MOST: usize = 100;

/// What is wrong at a path.
#[derive(Debug)]
pub struct Complaint {
    /// The path of the value at fault, or of the table in which the named key is.
    pub path: Option<String>,
    /// What is wrong there.
    pub fault: Fault,
}

/// What can be wrong with the form of a document.
#[derive(Clone, Debug)]
pub enum Fault {
    /// A key that must be given.
    Missing(String),
    /// A key that is not known, and those that are.
    Unknown(String, Vec<String>),
    /// A name that is not known, and those that are.
    Name(Vec<String>),
    /// Another value than what is allowed.
    Value(String),
}

/// The value `node` at `path` as a `T`, or everything that keeps it from being one.
pub fn read<T: DeserializeOwned>(node: &Spanned<DeValue<'_>>, path: &str) -> Result<T, Vec<Complaint>> {
    let mut mended = Mended::default();
    let mut complaints = Vec::new();
    loop {
        let reader = Reader { node, path: path.into(), mended: &mended };
        match T::deserialize(reader) {
            Ok(value) if complaints.is_empty() => return Ok(value),
            Ok(_) => return Err(complaints),
            Err(complaint) => {
                let again = mended.mend(&complaint);
                complaints.push(complaint);
                if !again || complaints.len() == MOST {
                    return Err(complaints);
                }
            }
        }
    }
}

/// What earlier complaints were about: mended, so that the next one can be found.
#[derive(Debug, Default)]
struct Mended {
    /// Keys left out.
    ignored: BTreeSet<String>,
    /// Values with a placeholder in their place.
    replaced: BTreeSet<String>,
    /// Missing keys by their table, added with a placeholder.
    added: BTreeMap<String, Vec<String>>,
}

impl Mended {
    /// False when it was mended already and that did not help.
    fn mend(&mut self, complaint: &Complaint) -> bool {
        let path = complaint.path.clone().unwrap_or_default();
        match &complaint.fault {
            Fault::Missing(name) => {
                let names = self.added.entry(path).or_default();
                let new = !names.contains(name);
                names.push(name.clone());
                new
            }
            Fault::Unknown(name, _) => self.ignored.insert(dotted(&path, name)),
            Fault::Name(_) | Fault::Value(_) => !path.is_empty() && self.replaced.insert(path),
        }
    }
}

impl std::error::Error for Complaint {}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}", self.path.as_deref().unwrap_or_default(), self.fault)
    }
}

impl Complaint {
    fn new(fault: Fault) -> Self {
        Self { path: None, fault }
    }

    /// The path is that of the innermost value.
    fn at(self, path: &str) -> Self {
        Self { path: self.path.or_else(|| Some(path.into())), fault: self.fault }
    }
}

fn names(known: &[&str]) -> Vec<String> {
    known.iter().map(|name| (*name).to_owned()).collect()
}

impl de::Error for Complaint {
    fn custom<T: fmt::Display>(what: T) -> Self {
        Self::new(Fault::Value(what.to_string()))
    }
    fn invalid_type(_: Unexpected, expected: &dyn de::Expected) -> Self {
        Self::new(Fault::Value(in_words(&expected.to_string())))
    }
    fn invalid_value(_: Unexpected, expected: &dyn de::Expected) -> Self {
        Self::new(Fault::Value(in_words(&expected.to_string())))
    }
    fn invalid_length(_: usize, expected: &dyn de::Expected) -> Self {
        Self::new(Fault::Value(in_words(&expected.to_string())))
    }
    fn unknown_variant(_: &str, known: &'static [&'static str]) -> Self {
        Self::new(Fault::Name(names(known)))
    }
    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(Fault::Unknown(name.into(), names(known)))
    }
    fn missing_field(name: &'static str) -> Self {
        Self::new(Fault::Missing(name.into()))
    }
    fn duplicate_field(name: &'static str) -> Self {
        Self::new(Fault::Value(format!("{name} once")))
    }
}

/// serde's names of types, in words.
fn in_words(expected: &str) -> String {
    let whole = ["u8", "u16", "u32", "u64", "usize"];
    match expected {
        "f64" | "f32" => "a number".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".into(),
        name if whole.contains(&name) => "a whole number, not negative".into(),
        "a boolean" => "true or false".into(),
        "a string" | "path string" => "text in quotes".into(),
        "a sequence" => "a list".into(),
        "a map" => "a table".into(),
        name if name.starts_with("struct ") => "a table".into(),
        other => other.replace("an array of length", "a list of length"),
    }
}

/// A value of the tree with its path.
struct Reader<'a, 'i> {
    node: &'a Spanned<DeValue<'i>>,
    path: String,
    mended: &'a Mended,
}

impl<'a, 'i> Reader<'a, 'i> {
    fn below(&self, node: &'a Spanned<DeValue<'i>>, path: String) -> Self {
        Self { node, path, mended: self.mended }
    }

    /// What `visit` says, with this value's path where it has none.
    fn located<T>(self, visit: impl FnOnce(&Self) -> Result<T, Complaint>) -> Result<T, Complaint> {
        visit(&self).map_err(|complaint| complaint.at(&self.path))
    }

    fn replaced(&self) -> bool {
        self.mended.replaced.contains(&self.path)
    }

    fn scalar<'de, V: Visitor<'de>>(&self, visitor: V) -> Result<V::Value, Complaint> {
        match self.node.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Float(float) => match float.as_str().parse() {
                Ok(value) => visitor.visit_f64(value),
                Err(_) => Err(Complaint::new(Fault::Value("a number".into()))),
            },
            DeValue::Integer(integer) => match i128::from_str_radix(integer.as_str(), integer.radix()) {
                Ok(value) => match (i64::try_from(value), u64::try_from(value)) {
                    (Ok(value), _) => visitor.visit_i64(value),
                    (_, Ok(value)) => visitor.visit_u64(value),
                    _ => visitor.visit_f64(value as f64),
                },
                Err(_) => Err(Complaint::new(Fault::Value("a whole number of fewer digits".into()))),
            },
            DeValue::Datetime(time) => visitor.visit_string(time.to_string()),
            DeValue::Array(_) => visitor.visit_seq(Items { reader: self, next: 0 }),
            DeValue::Table(_) => visitor.visit_map(Entries::new(self)),
        }
    }
}

impl<'de> Deserializer<'de> for Reader<'_, '_> {
    type Error = Complaint;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        self.located(|reader| reader.scalar(visitor))
    }

    forward_to_deserialize_any! {
        unit unit_struct identifier ignored_any
    }

    typed! {
        deserialize_bool deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64 deserialize_i128
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64 deserialize_u128
        deserialize_f32 deserialize_f64 deserialize_char deserialize_str deserialize_string
        deserialize_bytes deserialize_byte_buf deserialize_seq deserialize_map
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Complaint> {
        if self.replaced() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Complaint> {
        if self.replaced() {
            return Placeholder.deserialize_tuple(length, visitor);
        }
        self.located(|reader| match reader.node.get_ref() {
            DeValue::Array(items) if items.len() == length => reader.scalar(visitor),
            _ => Err(Complaint::new(Fault::Value(format!("a list of length {length}")))),
        })
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        if self.replaced() {
            return Placeholder.deserialize_struct(name, fields, visitor);
        }
        self.located(|reader| match reader.node.get_ref() {
            DeValue::Table(_) => reader.scalar(visitor),
            _ => Err(Complaint::new(Fault::Value("a table".into()))),
        })
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        if self.replaced() {
            return Placeholder.deserialize_enum(name, variants, visitor);
        }
        self.located(|reader| match reader.node.get_ref() {
            DeValue::String(text) => visitor.visit_enum(Choice { reader, name: text, inside: None }),
            DeValue::Table(table) => {
                let ignored = |key: &str| reader.mended.ignored.contains(&dotted(&reader.path, key));
                let mut kept = table.iter().filter(|(key, _)| !ignored(key.get_ref()));
                match (kept.next(), kept.next()) {
                    (Some((key, value)), None) => {
                        visitor.visit_enum(Choice { reader, name: key.get_ref(), inside: Some(value) })
                    }
                    _ => Err(Complaint::new(not_one_of(table.keys().map(|key| key.get_ref()), variants))),
                }
            }
            _ => Err(Complaint::new(Fault::Value(format!("one of {}", variants.join(", "))))),
        })
    }
}

/// What is wrong with a table that should hold one of `variants` alone and has these `keys`.
fn not_one_of<K: AsRef<str>>(mut keys: impl Iterator<Item = K>, variants: &[&str]) -> Fault {
    let unknown = keys.find(|key| !variants.contains(&key.as_ref()));
    let known = unknown.map(|key| Fault::Unknown(key.as_ref().into(), names(variants)));
    known.unwrap_or_else(|| Fault::Value(format!("one of {}, alone", variants.join(", "))))
}

/// The items of a list.
struct Items<'r, 'a, 'i> {
    reader: &'r Reader<'a, 'i>,
    next: usize,
}

impl<'de> SeqAccess<'de> for Items<'_, '_, '_> {
    type Error = Complaint;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Complaint> {
        let items = self.reader.node.get_ref().as_array();
        let Some(item) = items.and_then(|items| items.get(self.next)) else { return Ok(None) };
        let path = format!("{}[{}]", self.reader.path, self.next);
        self.next += 1;
        seed.deserialize(self.reader.below(item, path)).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        self.reader.node.get_ref().as_array().map(|items| items.len() - self.next.min(items.len()))
    }
}

/// The entries of a table, then those that are missing.
struct Entries<'r, 'a, 'i> {
    reader: &'r Reader<'a, 'i>,
    entries: Box<dyn Iterator<Item = (String, Option<&'a Spanned<DeValue<'i>>>)> + 'a>,
    current: Option<(String, Option<&'a Spanned<DeValue<'i>>>)>,
}

impl<'r, 'a, 'i> Entries<'r, 'a, 'i> {
    fn new(reader: &'r Reader<'a, 'i>) -> Self {
        let (mended, path) = (reader.mended, reader.path.clone());
        let added = mended.added.get(&path).into_iter().flatten().map(|name| (name.clone(), None));
        let table = reader.node.get_ref().as_table().into_iter().flat_map(|table| table.iter());
        let known = table
            .map(|(key, value)| (key.get_ref().to_string(), Some(value)))
            .filter(move |(key, _)| !mended.ignored.contains(&dotted(&path, key)));
        Self { reader, entries: Box::new(known.chain(added)), current: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'_, '_, '_> {
    type Error = Complaint;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Complaint> {
        self.current = self.entries.next();
        let Some((key, _)) = &self.current else { return Ok(None) };
        let key: StrDeserializer<'_, Complaint> = key.as_str().into_deserializer();
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Complaint> {
        match self.current.take() {
            Some((key, Some(node))) => {
                seed.deserialize(self.reader.below(node, dotted(&self.reader.path, &key)))
            }
            _ => seed.deserialize(Placeholder),
        }
    }
}

/// A variant by its name, with what it holds.
struct Choice<'r, 'a, 'i> {
    reader: &'r Reader<'a, 'i>,
    name: &'r str,
    inside: Option<&'a Spanned<DeValue<'i>>>,
}

impl<'a, 'i> Choice<'_, 'a, 'i> {
    fn inside(self) -> Result<Reader<'a, 'i>, Complaint> {
        let node = self.inside.ok_or_else(|| {
            Complaint::new(Fault::Value(format!("a table {} with what belongs to it", self.name)))
        })?;
        Ok(self.reader.below(node, dotted(&self.reader.path, self.name)))
    }
}

impl<'de> EnumAccess<'de> for Choice<'_, '_, '_> {
    type Error = Complaint;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Complaint> {
        let name: StrDeserializer<'_, Complaint> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for Choice<'_, '_, '_> {
    type Error = Complaint;

    fn unit_variant(self) -> Result<(), Complaint> {
        match self.inside {
            None => Ok(()),
            Some(_) => Err(Complaint::new(Fault::Value(format!("\"{}\" alone", self.name)))),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Complaint> {
        seed.deserialize(self.inside()?)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Complaint> {
        self.inside()?.deserialize_tuple(length, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Complaint> {
        self.inside()?.deserialize_struct("", fields, visitor)
    }
}
