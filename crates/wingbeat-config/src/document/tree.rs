//! Paths into a tree of TOML values: `a.b.list[0].c`, or `a.b.list.twist.c` of the item with the name `twist`; a name with dots or brackets stands between quotes, `numbers."body.com_m[0]"`.

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// The steps of a path: names, and numbers for the items of lists.
pub fn steps(path: &str) -> Vec<String> {
    let plain = |part: &str| -> Vec<String> {
        let steps = part.split(['.', '[']).map(|step| step.trim_end_matches(']').trim().to_owned());
        steps.filter(|step| !step.is_empty()).collect()
    };
    // Every other part stands between quotes.
    let parts = path.split('"').enumerate();
    parts.flat_map(|(i, part)| if i % 2 == 1 { vec![part.to_owned()] } else { plain(part) }).collect()
}

/// The path of `steps`.
pub fn path(steps: &[String]) -> String {
    steps.iter().fold(String::new(), |path, step| match step.parse::<usize>() {
        Ok(index) => format!("{path}[{index}]"),
        Err(_) => dotted(&path, step),
    })
}

/// `table.name`, or `name` alone at the root.
pub fn dotted(table: &str, name: &str) -> String {
    let name = if name.contains(['.', '[']) { format!("\"{name}\"") } else { name.into() };
    if table.is_empty() { name } else { format!("{table}.{name}") }
}

/// The place in a list of the item with the number or the name `step`.
fn place(items: &DeArray<'_>, step: &str) -> Option<usize> {
    let index = step.parse::<usize>().ok().filter(|index| *index < items.len());
    index.or_else(|| items.iter().position(|item| name(item) == Some(step)))
}

/// The name of an item of a list.
pub fn name<'a>(item: &'a Spanned<DeValue<'_>>) -> Option<&'a str> {
    item.get_ref().as_table()?.get("name")?.get_ref().as_str()
}

/// The value below `parent` called `step`.
pub fn child<'a, 'i>(parent: &'a DeValue<'i>, step: &str) -> Option<&'a Spanned<DeValue<'i>>> {
    match parent {
        DeValue::Table(table) => table.get(step),
        DeValue::Array(items) => items.get(place(items, step)?),
        _ => None,
    }
}

fn child_mut<'a, 'i>(parent: &'a mut DeValue<'i>, step: &str) -> Option<&'a mut Spanned<DeValue<'i>>> {
    match parent {
        DeValue::Table(table) => table.get_mut(step),
        DeValue::Array(items) => {
            let place = place(items, step)?;
            items.get_mut(place)
        }
        _ => None,
    }
}

/// The path `path` below `root` with the numbers of items of lists where it has their names.
pub fn numbered(root: &Spanned<DeValue<'_>>, at: &str) -> String {
    let mut value = Some(root);
    let mut found = steps(at);
    for step in &mut found {
        let below = value.and_then(|value| child(value.get_ref(), step));
        if let Some(DeValue::Array(items)) = value.map(Spanned::get_ref)
            && let Some(place) = place(items, step)
        {
            *step = place.to_string();
        }
        value = below;
    }
    path(&found)
}

/// The value at `path` below `root`.
pub fn follow<'a, 'i>(root: &'a Spanned<DeValue<'i>>, path: &str) -> Option<&'a Spanned<DeValue<'i>>> {
    steps(path).iter().try_fold(root, |value, step| child(value.get_ref(), step))
}

/// The value at `steps` below `root`; an empty table where there is none.
pub fn taken<'i>(root: Spanned<DeValue<'i>>, steps: &[String]) -> Spanned<DeValue<'i>> {
    steps.iter().fold(root, |value, step| {
        let span = value.span();
        let below = match value.into_inner() {
            DeValue::Table(mut table) => table.remove(step.as_str()),
            _ => None,
        };
        below.unwrap_or_else(|| Spanned::new(span, DeValue::Table(DeTable::new())))
    })
}

/// The steps to the first table below `root` that stands under the key `name`.
pub fn table_called(root: &Spanned<DeValue<'_>>, name: &str) -> Option<Vec<String>> {
    let below = |step: String, value: &Spanned<DeValue<'_>>| {
        if step == name && value.get_ref().is_table() {
            return Some(vec![step]);
        }
        let steps = table_called(value, name)?;
        Some(std::iter::once(step).chain(steps).collect())
    };
    match root.get_ref() {
        DeValue::Table(table) => {
            table.iter().find_map(|(key, value)| below(key.get_ref().to_string(), value))
        }
        DeValue::Array(items) => items.iter().enumerate().find_map(|(k, value)| below(k.to_string(), value)),
        _ => None,
    }
}

/// Shows every value below `root` that is neither table nor list, with its path.
pub fn walk<'a, 'i>(root: &'a Spanned<DeValue<'i>>, visit: &mut dyn FnMut(&str, &'a Spanned<DeValue<'i>>)) {
    walk_below("", root, visit);
}

fn walk_below<'a, 'i>(
    path: &str,
    value: &'a Spanned<DeValue<'i>>,
    visit: &mut dyn FnMut(&str, &'a Spanned<DeValue<'i>>),
) {
    match value.get_ref() {
        DeValue::Table(table) => {
            table.iter().for_each(|(key, value)| walk_below(&dotted(path, key.get_ref()), value, visit));
        }
        DeValue::Array(items) => {
            let items = items.iter().enumerate();
            items.for_each(|(index, value)| walk_below(&format!("{path}[{index}]"), value, visit));
        }
        _ => visit(path, value),
    }
}

/// The value at `steps` below `root`, which is left empty there; an empty table where there is none.
pub fn swap<'i>(root: &mut Spanned<DeValue<'i>>, steps: &[String]) -> Spanned<DeValue<'i>> {
    let empty = || Spanned::new(0..0, DeValue::Table(DeTable::new()));
    match steps.iter().try_fold(root, |value, step| child_mut(value.get_mut(), step)) {
        Some(value) => std::mem::replace(value, empty()),
        None => empty(),
    }
}

/// Takes away the alternative in the place of which what is put at `steps` below `root` comes: alone in its table on the way,
/// where `written` says that it stands in a file, and another of the same choice, by `alternatives`, than the step that leads on.
pub fn displace(
    root: &mut Spanned<DeValue<'_>>,
    steps: &[String],
    written: &dyn Fn(usize) -> bool,
    alternatives: &dyn Fn(&str, &str) -> bool,
) {
    let mut value = root;
    for step in steps {
        if let DeValue::Table(table) = value.get_mut()
            && table.len() == 1
            && table.iter().all(|(key, _)| written(key.span().start) && alternatives(key.get_ref(), step))
        {
            *table = DeTable::new();
        }
        let Some(below) = child_mut(value.get_mut(), step) else { return };
        value = below;
    }
}

/// What is allowed in a list where no item is called `step`.
fn instead(items: &DeArray<'_>, step: &str) -> String {
    let last = items.len().saturating_sub(1);
    let names: Vec<&str> = items.iter().filter_map(name).collect();
    let named = if names.is_empty() { String::new() } else { format!(" or a name of {}", names.join(", ")) };
    format!("an index from 0 to {last}{named} in place of {step}")
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
            let item = place(items, step).and_then(|place| items.get_mut(place));
            match item {
                Some(item) => assign(item, rest, value),
                None => Err(instead(items, step)),
            }
        }
        other => Err(format!("a key of a table; {step} would be inside a {}", other.type_str())),
    }
}

/// Takes what stands at `steps` out of the tables.
pub fn remove(table: &mut toml::Table, steps: &[String]) {
    match steps {
        [] => {}
        [key] => drop(table.remove(key)),
        [key, rest @ ..] => {
            if let Some(inner) = table.get_mut(key).and_then(toml::Value::as_table_mut) {
                remove(inner, rest);
            }
        }
    }
}
