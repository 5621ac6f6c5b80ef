//! What a table of a scenario chooses: what ships, by its own keys, or another kind under its name.

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{DeserializeOwned, DeserializeSeed, Error as _, IntoDeserializer, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer, forward_to_deserialize_any};
use std::cell::Cell;
use std::fmt;
use std::marker::PhantomData;

/// The kind that ships, or one of [`Doors`](super::Doors).
#[derive(Clone, Debug)]
pub enum Chosen<T> {
    /// What ships.
    Shipped(T),
    /// Another kind.
    Own(Named),
}

/// A table under the name of its kind: `[manoeuvre.weave]`.
#[derive(Clone, Debug)]
pub struct Named {
    /// The name.
    pub name: String,
    /// What stands in the table.
    pub keys: toml::Table,
}

impl<T> Chosen<T> {
    /// What ships, if that is chosen.
    pub fn shipped(&self) -> Option<&T> {
        match self {
            Self::Shipped(shipped) => Some(shipped),
            Self::Own(_) => None,
        }
    }
}

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(&self.name, &self.keys)?;
        map.end()
    }
}

impl<T: Serialize> Serialize for Chosen<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Shipped(shipped) => shipped.serialize(serializer),
            Self::Own(named) => named.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Named {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OneName)
    }
}

impl<'de, T: DeserializeOwned> Deserialize<'de> for Chosen<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Either(PhantomData))
    }
}

/// Visits a table with one table in it.
struct OneName;

impl<'de> Visitor<'de> for OneName {
    type Value = Named;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table under the name of its kind")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Named, A::Error> {
        let alone = || A::Error::custom("one table, under the name of its kind");
        let name = map.next_key()?.ok_or_else(alone)?;
        only(name, map)?.ok_or_else(alone)
    }
}

/// The table under `name`, which has been read; none if it is no table or not alone.
fn only<'de, A: MapAccess<'de>>(name: String, mut map: A) -> Result<Option<Named>, A::Error> {
    let value = map.next_value()?;
    match (value, map.next_key::<String>()?) {
        (toml::Value::Table(keys), None) => Ok(Some(Named { name, keys })),
        _ => Ok(None),
    }
}

/// Visits a table: the first key tells which of both it is.
struct Either<T>(PhantomData<T>);

impl<'de, T: DeserializeOwned> Visitor<'de> for Either<T> {
    type Value = Chosen<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Chosen<T>, A::Error> {
        let (first, keys): (Option<String>, _) = (map.next_key()?, keys_of::<T>());
        match first {
            Some(name) if !keys.contains(&name.as_str()) => {
                let unknown = A::Error::unknown_field(&name, keys);
                only(name, map)?.map(Chosen::Own).ok_or(unknown)
            }
            first => T::deserialize(MapAccessDeserializer::new(Again { first, map })).map(Chosen::Shipped),
        }
    }
}

/// A table whose first key has been read.
struct Again<A> {
    first: Option<String>,
    map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Again<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        let Some(first) = self.first.take() else { return self.map.next_key_seed(seed) };
        let first: StrDeserializer<'_, A::Error> = first.as_str().into_deserializer();
        seed.deserialize(first).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

/// The keys of the table that is a `T`.
pub fn keys_of<T: DeserializeOwned>() -> &'static [&'static str] {
    let keys: Cell<&'static [&'static str]> = Cell::new(&[]);
    // Asked for its fields, a type answers before it sees that there is nothing to read.
    let _ = T::deserialize(Fields(&keys));
    keys.get()
}

/// Notes the fields that are asked for.
struct Fields<'a>(&'a Cell<&'static [&'static str]>);

impl<'de> Deserializer<'de> for Fields<'_> {
    type Error = serde::de::value::Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Self::Error> {
        self.0.set(fields);
        self.deserialize_any(visitor)
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
        Err(Self::Error::custom("nothing to read"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}
