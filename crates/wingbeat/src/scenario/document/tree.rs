//! Paths into a tree of TOML values: `a.b.list[0].c`.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value with the span of its key; items of a list have none.
pub struct Node<'a, 'i> {
    pub key: Option<Range<usize>>,
    pub value: &'a Spanned<DeValue<'i>>,
}

/// The steps of a path: names, and numbers for the items of lists.
pub fn steps(path: &str) -> Vec<String> {
    path.split(['.', '['])
        .map(|step| step.trim_end_matches(']').trim().to_owned())
        .filter(|s| !s.is_empty())
        .collect()
}

/// The value below `parent` called `step`.
pub fn child<'a, 'i>(parent: &'a DeValue<'i>, step: &str) -> Option<Node<'a, 'i>> {
    match parent {
        DeValue::Table(table) => {
            table.get_key_value(step).map(|(key, value)| Node { key: Some(key.span()), value })
        }
        DeValue::Array(items) => Some(Node { key: None, value: items.get(step.parse::<usize>().ok()?)? }),
        _ => None,
    }
}

/// The first value, in order, that `wanted` accepts: its path and span.
pub fn find<'i>(
    root: &Spanned<DeValue<'i>>,
    wanted: &dyn Fn(&Node<'_, 'i>) -> bool,
) -> Option<(String, Range<usize>)> {
    search(&Node { key: None, value: root }, "", wanted)
}

fn search<'i>(
    node: &Node<'_, 'i>,
    path: &str,
    wanted: &dyn Fn(&Node<'_, 'i>) -> bool,
) -> Option<(String, Range<usize>)> {
    if wanted(node) {
        return Some((path.into(), node.value.span()));
    }
    match node.value.get_ref() {
        DeValue::Table(table) => table.iter().find_map(|(key, value)| {
            let dot = if path.is_empty() { "" } else { "." };
            search(&Node { key: Some(key.span()), value }, &format!("{path}{dot}{}", key.get_ref()), wanted)
        }),
        DeValue::Array(items) => items.iter().enumerate().find_map(|(index, value)| {
            search(&Node { key: None, value }, &format!("{path}[{index}]"), wanted)
        }),
        _ => None,
    }
}

/// Puts `value` at `steps` below `target`; tables that are not there are made.
///
/// # Errors
/// What is allowed instead.
pub fn assign<'i>(
    target: &mut Spanned<DeValue<'i>>,
    steps: &[String],
    value: Spanned<DeValue<'i>>,
) -> Result<(), String> {
    let Some((step, rest)) = steps.split_first() else {
        *target = value;
        return Ok(());
    };
    match target.get_mut() {
        DeValue::Table(table) => {
            let span = value.span();
            let key = Spanned::new(span.clone(), step.clone().into());
            let entry =
                table.entry(key).or_insert_with(|| Spanned::new(span, DeValue::Table(DeTable::new())));
            assign(entry, rest, value)
        }
        DeValue::Array(items) => {
            let last = items.len().saturating_sub(1);
            let item = step.parse::<usize>().ok().and_then(|index| items.get_mut(index));
            let item = item.ok_or_else(|| format!("an index from 0 to {last} in place of {step}"))?;
            assign(item, rest, value)
        }
        other => Err(format!("a key of a table; {step} would be inside a {}", other.type_str())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_have_names_and_indices() {
        assert_eq!(steps("a.b[2].c"), ["a", "b", "2", "c"]);
        assert_eq!(steps("a.b.2"), ["a", "b", "2"]);
    }
}
