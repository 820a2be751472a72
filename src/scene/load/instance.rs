//! Reads the `[[instance]]` tables of a scene file, and checks the groups that they place.
//!
//! Measure: world units.
//! Range: every group that is placed has a member; no group is placed within itself.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

use super::contents::SceneContents;
use super::motion::motion;
use super::reader::{Table, Value};
use super::transform::transform;
use super::wording::{shown, unknown_name};
use crate::error::Result;
use crate::math::vec::DAffine3;
use crate::scene::description::{InstanceDescription, Note, NoteKind, Place};
use std::collections::HashSet;
use std::path::Path;

/// Reads all `[[instance]]` tables; called after all shapes are read, so that all groups are known.
///
/// # Errors
/// If an entry is not as the format requires; if a placed group has no members; if groups contain one another in a
/// cycle.
pub fn instances(values: &[Value<'_>], file: &Path, contents: &mut SceneContents) -> Result<()> {
    // Instances are members, too: an earlier instance may place a group whose only members are instances further down.
    for value in values {
        group(&value.table()?, contents)?;
    }
    let mut placed = Vec::with_capacity(values.len());
    for (index, value) in values.iter().enumerate() {
        let (instance, of) = instance(value, file, index, contents)?;
        contents.instances.push(instance);
        placed.push(of);
    }
    refuse_circles(&contents.groups, &contents.instances, &placed)?;
    note_unseen(contents);
    Ok(())
}

/// Notes groups that no instance places.
fn note_unseen(contents: &mut SceneContents) {
    let placed: HashSet<usize> = contents.instances.iter().map(|it| it.of).collect();
    let unseen = (0..contents.groups.len()).filter(|group| !placed.contains(group));
    for group in unseen {
        let name = shown(&contents.groups[group]);
        contents.note(Note::of_scene(
            NoteKind::Decision,
            format!("group `{name}` is placed by no instance: it is not rendered"),
        ));
    }
}

/// Returns the group that an object belongs to, if any.
///
/// # Errors
/// If the name is not a string.
pub fn group(table: &Table<'_>, contents: &mut SceneContents) -> Result<Option<usize>> {
    let Some(name) = table.optional("group") else {
        return Ok(None);
    };
    Ok(Some(contents.add_to_group(name.text()?)))
}

/// Reads one `[[instance]]` table; also returns the value that names the placed group.
fn instance<'a>(
    value: &Value<'a>,
    file: &Path,
    index: usize,
    contents: &mut SceneContents,
) -> Result<(InstanceDescription, Value<'a>)> {
    let table = value.table()?;
    let of = table.required("of")?;
    let of_name = of.text()?;
    let placed = contents
        .group_named(of_name)
        .ok_or_else(|| of.error(unknown_name("group", of_name, &contents.group_names())))?;
    let name = match table.optional("name") {
        Some(name) => name.text()?.to_owned(),
        None => format!("instance {}", index + 1),
    };
    let instance = InstanceDescription {
        place: Place::on_line(file, value.line()),
        of: placed,
        group: group(&table, contents)?,
        transform: table
            .optional("transform")
            .map_or(Ok(DAffine3::IDENTITY), |value| transform(&value, &name))?,
        motion: motion(&table, &name)?,
        name,
    };
    table.finish()?;
    Ok((instance, of))
}

/// The state of a group in the search for cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Search {
    Ahead,
    OnThePath,
    Done,
}

/// Searches for cycles depth first through the instances within each group; `placed` are the values that name the placed
/// groups.
///
/// # Errors
/// The first cycle that is found, reported at the instance that closes it.
fn refuse_circles(
    groups: &[String],
    instances: &[InstanceDescription],
    placed: &[Value<'_>],
) -> Result<()> {
    let mut within = vec![vec![]; groups.len()];
    for (index, instance) in instances.iter().enumerate() {
        if let Some(group) = instance.group {
            within[group].push(index);
        }
    }
    let mut search = vec![Search::Ahead; groups.len()];
    for start in 0..groups.len() {
        // The groups on the current path, each with the number of its instances that were followed. An explicit stack,
        // since the chain of groups may be as long as the file.
        let mut path = vec![];
        if search[start] == Search::Ahead {
            path.push((start, 0));
            search[start] = Search::OnThePath;
        }
        while let Some((group, followed)) = path.last_mut() {
            let Some(&next) = within[*group].get(*followed) else {
                search[*group] = Search::Done;
                path.pop();
                continue;
            };
            *followed += 1;
            let of = instances[next].of;
            match search[of] {
                Search::Done => {}
                Search::Ahead => {
                    search[of] = Search::OnThePath;
                    path.push((of, 0));
                }
                Search::OnThePath => {
                    let circle = path.iter().map(|(group, _)| *group);
                    let circle = circle.skip_while(|group| *group != of).chain([of]);
                    let names: Vec<String> = circle.map(|group| shown(&groups[group])).collect();
                    return Err(placed[next].error(format!(
                        "groups are placed within one another in a cycle: {}",
                        names.join(" -> ")
                    )));
                }
            }
        }
    }
    Ok(())
}
