//! One document over another: tables go together key by key, items of lists by their name.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::tree;

/// The key of a document that names the file that it is based on.
pub const BASE: &str = "base";
/// The key of a document with the keys of its base that it has not.
pub const WITHOUT: &str = "without";

type BasedTree<'i> = Spanned<DeValue<'i>>;

/// A value that is refused.
pub struct Refused {
    /// Its key.
    pub key: String,
    /// Where it stands.
    pub span: Range<usize>,
    /// What is allowed.
    pub allowed: String,
}

/// `own` over `base`, less the keys that `own` is without.
///
/// # Errors
/// A list of keys of which `base` does not have each.
pub fn over<'i>(mut base: BasedTree<'i>, mut own: BasedTree<'i>) -> Result<BasedTree<'i>, Refused> {
    if let DeValue::Table(table) = own.get_mut() {
        table.remove(BASE);
        if let Some(without) = table.remove(WITHOUT) {
            leave_out(&mut base, &without)?;
        }
    }
    Ok(merged(base, own))
}

fn leave_out(base: &mut BasedTree, without: &BasedTree) -> Result<(), Refused> {
    let refused = |key: String, value: &BasedTree, allowed: &str| {
        Err(Refused { key, span: value.span(), allowed: allowed.into() })
    };
    let DeValue::Array(keys) = without.get_ref() else {
        return refused(WITHOUT.into(), without, "a list of keys of the base");
    };
    for (index, key) in keys.iter().enumerate() {
        let steps = key.get_ref().as_str().map(tree::steps).unwrap_or_default();
        if !remove(base, &steps) {
            let allowed = "a key of the base, such as body.com_m or links.elbow.driven";
            return refused(format!("{WITHOUT}[{index}]"), key, allowed);
        }
    }
    Ok(())
}

/// Takes what stands at `steps` out of `value`, where items of lists are called by their name; false if nothing does.
fn remove(value: &mut BasedTree<'_>, steps: &[String]) -> bool {
    let Some((step, rest)) = steps.split_first() else { return false };
    match value.get_mut() {
        DeValue::Table(table) if rest.is_empty() => table.remove(step.as_str()).is_some(),
        DeValue::Table(table) => table.get_mut(step.as_str()).is_some_and(|below| remove(below, rest)),
        DeValue::Array(items) => {
            let Some(index) = items.iter().position(|item| tree::name(item) == Some(step)) else {
                return false;
            };
            if rest.is_empty() {
                *items = without(std::mem::replace(items, DeArray::new()), index);
                return true;
            }
            items.get_mut(index).is_some_and(|below| remove(below, rest))
        }
        _ => false,
    }
}

fn without(items: DeArray<'_>, index: usize) -> DeArray<'_> {
    items.into_iter().enumerate().filter(|(i, _)| *i != index).map(|(_, item)| item).collect()
}

/// `own` over `base`: what is in both is that of `own`.
fn merged<'i>(base: BasedTree<'i>, own: BasedTree<'i>) -> BasedTree<'i> {
    let span = own.span();
    let value = match (base.into_inner(), own.into_inner()) {
        (DeValue::Table(base), DeValue::Table(own)) => DeValue::Table(table(base, own)),
        (DeValue::Array(base), DeValue::Array(own)) if all_named(&base) && all_named(&own) => {
            DeValue::Array(list(base, own))
        }
        (_, own) => own,
    };
    Spanned::new(span, value)
}

fn table<'i>(mut base: DeTable<'i>, own: DeTable<'i>) -> DeTable<'i> {
    for (key, value) in own {
        let value = match base.remove(key.get_ref().as_ref() as &str) {
            Some(below) => merged(below, value),
            None => value,
        };
        base.insert(key, value);
    }
    base
}

/// The items of `base` in their order, each under that of `own` with its name, then the others of `own`.
fn list<'i>(base: DeArray<'i>, own: DeArray<'i>) -> DeArray<'i> {
    let mut own: Vec<BasedTree> = own.into_iter().collect();
    let mut items = Vec::new();
    for item in base {
        let same = own.iter().position(|other| tree::name(other) == tree::name(&item));
        items.push(match same {
            Some(index) => merged(item, own.remove(index)),
            None => item,
        });
    }
    items.into_iter().chain(own).collect()
}

fn all_named(items: &DeArray) -> bool {
    !items.is_empty() && items.iter().all(|item| tree::name(item).is_some())
}
