//! What is in a list, a table or a choice of a document, one after another.

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use toml::Spanned;
use toml::de::DeValue;

use super::{Complaint, FormFault, Reader, dotted};

/// The items of a list, or so many placeholders.
pub(super) struct Items<'r, 'a, 'i> {
    pub(super) reader: &'r Reader<'a, 'i>,
    pub(super) next: usize,
    pub(super) placeholders: Option<usize>,
}

impl<'r, 'a, 'i> Items<'r, 'a, 'i> {
    pub(super) fn new(reader: &'r Reader<'a, 'i>) -> Self {
        Self { reader, next: 0, placeholders: None }
    }

    fn list(&self) -> &'a [Spanned<DeValue<'i>>] {
        self.reader.node.and_then(|node| node.get_ref().as_array()).map_or(&[], |items| items)
    }

    fn item(&mut self) -> Option<Reader<'a, 'i>> {
        let at = self.next;
        self.next += 1;
        match self.placeholders {
            Some(count) => (at < count).then(|| self.reader.placeholder()),
            None => {
                let path = || format!("{}[{at}]", self.reader.path);
                self.list().get(at).map(|item| self.reader.below(item, path()))
            }
        }
    }
}

impl<'de> SeqAccess<'de> for Items<'_, '_, '_> {
    type Error = Complaint;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Complaint> {
        self.item().map(|item| seed.deserialize(item)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        self.placeholders.is_none().then(|| self.list().len().saturating_sub(self.next))
    }
}

/// The entries of a table, then those that are missing.
pub(super) struct Entries<'r, 'a, 'i> {
    pub(super) reader: &'r Reader<'a, 'i>,
    entries: Box<dyn Iterator<Item = (String, Option<&'a Spanned<DeValue<'i>>>)> + 'a>,
    current: Option<(String, Option<&'a Spanned<DeValue<'i>>>)>,
}

impl<'r, 'a, 'i> Entries<'r, 'a, 'i> {
    pub(super) fn new(reader: &'r Reader<'a, 'i>) -> Self {
        let (mended, path) = (reader.mended, reader.path.clone());
        let added = mended.added.get(&path).into_iter().flatten().map(|name| (name.clone(), None));
        let table = reader.node.and_then(|node| node.get_ref().as_table());
        let table = table.into_iter().flat_map(|table| table.iter());
        let known = table
            .map(|(key, value)| (key.get_ref().to_string(), Some(value)))
            .filter(move |(key, _)| !mended.ignored.contains(&dotted(&path, key)));
        Self { reader, entries: Box::new(known.chain(added)), current: None }
    }

    /// A placeholder under each key.
    pub(super) fn placeholders(reader: &'r Reader<'a, 'i>, keys: &'static [&'static str]) -> Self {
        let entries = keys.iter().map(|key| ((*key).to_owned(), None));
        Self { reader, entries: Box::new(entries), current: None }
    }

    /// The value of the key that was told last.
    fn current(&mut self) -> Reader<'a, 'i> {
        match self.current.take() {
            Some((key, Some(node))) => self.reader.below(node, dotted(&self.reader.path, &key)),
            _ => self.reader.placeholder(),
        }
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
        seed.deserialize(self.current())
    }
}

/// A variant by its name, with what it holds.
pub(super) struct VariantChoice<'r, 'a, 'i> {
    pub(super) reader: &'r Reader<'a, 'i>,
    pub(super) name: &'r str,
    pub(super) inside: Option<&'a Spanned<DeValue<'i>>>,
}

impl<'a, 'i> VariantChoice<'_, 'a, 'i> {
    fn inside(self) -> Result<Reader<'a, 'i>, Complaint> {
        if self.reader.replaced {
            return Ok(self.reader.placeholder());
        }
        let node = self.inside.ok_or_else(|| {
            Complaint::new(FormFault::Value(format!("a table {} with what belongs to it", self.name)))
        })?;
        Ok(self.reader.below(node, dotted(&self.reader.path, self.name)))
    }
}

impl<'de> EnumAccess<'de> for VariantChoice<'_, '_, '_> {
    type Error = Complaint;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Complaint> {
        let name: StrDeserializer<'_, Complaint> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for VariantChoice<'_, '_, '_> {
    type Error = Complaint;

    fn unit_variant(self) -> Result<(), Complaint> {
        match self.inside {
            None => Ok(()),
            Some(_) => Err(Complaint::new(FormFault::Value(format!("\"{}\" alone", self.name)))),
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
