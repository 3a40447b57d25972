//! Folders of hostile and of unlucky users: killed runs, changed files, links, lists of others.

use super::*;
use std::collections::BTreeMap;

const COMMAND: &str = "fab";

fn files(list: &[(&str, &str)]) -> Vec<NamedFile> {
    let file = |&(name, text): &(&str, &str)| (name.to_owned(), text.as_bytes().to_vec());
    list.iter().map(file).collect()
}

fn old() -> Vec<NamedFile> {
    files(&[
        ("sheets/1.dxf", "old 1"),
        ("sheets/2.dxf", "old 2"),
        ("same.csv", "same"),
        ("fab.json", "old"),
    ])
}

fn new() -> Vec<NamedFile> {
    files(&[
        ("sheets/1.dxf", "new 1"),
        ("solids/a.obj", "new a"),
        ("same.csv", "same"),
        ("fab.json", "new"),
    ])
}

/// Every file below a folder with its content.
fn content(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for entry in fs::read_dir(&at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
                found.insert(name.to_owned(), fs::read_to_string(&path).unwrap());
            }
        }
    }
    found
}

fn whole(path: &Path) -> OutputFolder<'_> {
    OutputFolder::new(path, COMMAND, Extent::Whole)
}

/// A folder of an earlier run with files of the user in it.
fn used() -> (tempfile::TempDir, [&'static str; 2]) {
    let shop = tempfile::tempdir().unwrap();
    let place = shop.path().join("ws");
    whole(&place).write(&old()).unwrap();
    let notes = ["notes.txt", "sheets/offer.txt"];
    for name in notes {
        fs::write(place.join(name), name).unwrap();
    }
    (shop, notes)
}

fn assert_written(place: &Path, files: &[NamedFile], notes: &[&str], after: &str) {
    let mut found = content(place);
    let list = found.remove(LIST).expect("there is a list");
    assert_eq!(
        list,
        List::of(files).text(COMMAND),
        "list after killing {after}"
    );
    let mut expected: BTreeMap<String, String> = notes
        .iter()
        .map(|n| (n.to_string(), n.to_string()))
        .collect();
    for (name, bytes) in files {
        expected.insert(name.clone(), String::from_utf8(bytes.clone()).unwrap());
    }
    assert_eq!(found, expected, "files after killing {after}");
}

/// Files that are no longer made go; what the user has put there stays.
#[test]
fn a_second_run_replaces_only_what_the_first_one_wrote() {
    let (shop, notes) = used();
    let place = shop.path().join("ws");
    whole(&place).check(&[], &[]).unwrap();
    whole(&place).write(&new()).unwrap();
    assert_written(&place, &new(), &notes, "nothing");
}

/// After any number of steps, and in the midst of writing any file: each file of the user is there;
/// each old file, or each new file, is whole; the next run ends as if nothing had happened.
#[test]
fn a_run_that_is_killed_at_any_moment_loses_nothing() {
    for k in 0.. {
        let (shop, notes) = used();
        let place = shop.path().join("ws");
        let folder = whole(&place);
        let lock = folder.locked_stage().unwrap();
        let [staged, placed] = folder.steps(&new()).unwrap();
        let steps: Vec<&FolderStep> = staged.iter().chain(&placed).collect();
        if k > steps.len() {
            break;
        }
        steps[..k].iter().for_each(|step| step.run(&place).unwrap());
        if let Some(FolderStep::Stage { name, bytes }) = steps.get(k) {
            let half = name.clone();
            let part = FolderStep::Stage {
                name: half,
                bytes: bytes[..bytes.len() / 2].to_vec(),
            };
            part.run(&place).unwrap();
        }
        drop(lock);

        let found = content(&place);
        assert!(notes.iter().all(|n| found[*n] == *n));
        let holds = |files: &[NamedFile], stage: bool| {
            files.iter().all(|(name, bytes)| {
                let at = |name: &str| found.get(name).is_some_and(|t| t.as_bytes() == bytes);
                at(name) || (stage && at(&format!("{STAGE}/{name}")))
            })
        };
        assert!(
            holds(&old(), false) || holds(&new(), true),
            "neither old nor new files are whole after {k} steps"
        );
        folder.check(&[], &[]).unwrap();
        folder.write(&new()).unwrap();
        assert_written(&place, &new(), &notes, &format!("it after {k} steps"));
        folder.write(&old()).unwrap();
        assert_written(&place, &old(), &notes, &format!("it after {k} steps, back"));
    }
}

#[test]
fn a_first_run_that_is_killed_does_not_keep_the_next_one_out() {
    for k in 0..=12 {
        let shop = tempfile::tempdir().unwrap();
        let place = shop.path().join("ws");
        let folder = whole(&place);
        let lock = folder.locked_stage().unwrap();
        let [staged, placed] = folder.steps(&new()).unwrap();
        let steps = staged.iter().chain(&placed).take(k);
        steps.for_each(|step| step.run(&place).unwrap());
        drop(lock);
        folder.check(&[], &[]).unwrap();
        folder.write(&new()).unwrap();
        assert_written(&place, &new(), &[], &format!("it after {k} steps"));
    }
}

fn refused(folder: OutputFolder<'_>, files: &[NamedFile], texts: &[&str]) {
    let before = content(folder.path);
    let failure = folder.write(files).unwrap_err();
    assert_eq!(failure.exit, Exit::InputUnusable, "{failure}");
    for text in texts {
        assert!(failure.to_string().contains(text), "`{text}`: {failure}");
    }
    assert_eq!(content(folder.path), before, "nothing comes or goes");
}

#[test]
fn files_that_the_user_changed_or_put_in_the_way_are_refused() {
    let (shop, _) = used();
    let place = shop.path().join("ws");
    // The second sheet would go, the first one and the table be written over.
    for name in ["sheets/2.dxf", "sheets/1.dxf", "same.csv"] {
        let before = fs::read(place.join(name)).unwrap();
        fs::write(place.join(name), "mine").unwrap();
        refused(whole(&place), &new(), &[name, "changed since", "move them"]);
        fs::write(place.join(name), before).unwrap();
    }
    fs::create_dir(place.join("solids")).unwrap();
    fs::write(place.join("solids/a.obj"), "mine").unwrap();
    refused(whole(&place), &new(), &["solids/a.obj is in the way"]);
    // The same bytes are no excuse: nobody knows whose they are.
    fs::write(place.join("solids/a.obj"), "new a").unwrap();
    refused(whole(&place), &new(), &["solids/a.obj is in the way"]);
    fs::remove_dir_all(place.join("solids")).unwrap();
    fs::write(place.join("solids"), "a file").unwrap();
    refused(whole(&place), &new(), &["solids/a.obj is in the way"]);
    fs::remove_file(place.join("solids")).unwrap();
    whole(&place).write(&new()).unwrap();
}

#[test]
fn lists_of_others_are_refused() {
    let shop = tempfile::tempdir().unwrap();
    let place = shop.path().join("ws");
    fs::create_dir(&place).unwrap();
    fs::write(shop.path().join("precious"), "x").unwrap();
    let sum = "2d711642b726b04401627ca9fbac32f5c8530fb1903cc4db02258717921a4881";
    let head = List::default().text(COMMAND);
    for (list, cause) in [
        (format!("{sum}  notes.txt\n"), "not a list"),
        (List::default().text("offset"), "not a list"),
        (format!("{head}{sum}  ../precious\n"), "line 2"),
        (format!("{head}{sum}  /etc/passwd\n"), "line 2"),
        (format!("{head}{sum}\n"), "line 2"),
        (format!("{head}0  a\n"), "line 2"),
    ] {
        fs::write(place.join(LIST), list).unwrap();
        refused(whole(&place), &new(), &[LIST, cause]);
    }
    fs::write(place.join(LIST), [0xff, 0xfe]).unwrap();
    let failure = whole(&place).write(&new()).unwrap_err();
    assert_eq!(failure.exit, Exit::InputUnusable);
    assert_eq!(fs::read(shop.path().join("precious")).unwrap(), b"x");
}

#[test]
fn added_files_leave_those_of_earlier_runs_and_of_others() {
    let shop = tempfile::tempdir().unwrap();
    let place = shop.path();
    let folder = OutputFolder::new(place, "offset", Extent::Added);
    fs::write(place.join("mesh.obj"), "mine").unwrap();
    folder.write(&files(&[("a.obj", "a")])).unwrap();
    folder.write(&files(&[("b.obj", "b")])).unwrap();
    folder.write(&files(&[("b.obj", "c")])).unwrap();
    refused(
        folder,
        &files(&[("mesh.obj", "m")]),
        &["mesh.obj is in the way"],
    );
    let expected = [("a.obj", "a"), ("b.obj", "c"), ("mesh.obj", "mine")];
    let mut found = content(place);
    let list = found.remove(LIST).unwrap();
    assert_eq!(list, List::of(&files(&expected[..2])).text("offset"));
    assert!(
        found
            .iter()
            .map(|(n, t)| (n.as_str(), t.as_str()))
            .eq(expected)
    );

    // One that the user has changed is neither written over nor removed, nor listed any more.
    fs::write(place.join("a.obj"), "mine now").unwrap();
    folder.write(&files(&[("b.obj", "d")])).unwrap();
    let found = content(place);
    assert_eq!(found["a.obj"], "mine now");
    let list = List::of(&files(&[("b.obj", "d")]));
    assert_eq!(found[LIST], list.text("offset"));
    refused(folder, &files(&[("a.obj", "a")]), &["a.obj is in the way"]);
}

#[test]
fn a_second_run_at_the_same_time_is_refused() {
    let (shop, _) = used();
    let place = shop.path().join("ws");
    let lock = whole(&place).locked_stage().unwrap();
    refused(whole(&place), &new(), &["another run"]);
    drop(lock);
    whole(&place).write(&new()).unwrap();
}

#[cfg(unix)]
#[test]
fn links_are_kept_and_lead_nowhere_else() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let (shop, notes) = used();
    let (place, link) = (shop.path().join("ws"), shop.path().join("link"));
    symlink("ws", &link).unwrap();
    let private = fs::Permissions::from_mode(0o600);
    fs::set_permissions(place.join("fab.json"), private).unwrap();
    whole(&link).write(&new()).unwrap();
    assert!(link.is_symlink());
    assert_written(&place, &new(), &notes, "nothing");
    let mode = fs::metadata(place.join("fab.json")).unwrap().permissions();
    assert_eq!(mode.mode() & 0o777, 0o600);

    // Folders and files that have been replaced by links are the user's.
    let away = shop.path().join("away");
    fs::rename(place.join("sheets"), &away).unwrap();
    symlink(&away, place.join("sheets")).unwrap();
    refused(whole(&place), &old(), &["sheets/1.dxf"]);
    fs::remove_file(place.join("sheets")).unwrap();
    fs::rename(&away, place.join("sheets")).unwrap();
    fs::rename(place.join("fab.json"), &away).unwrap();
    symlink(&away, place.join("fab.json")).unwrap();
    refused(whole(&place), &old(), &["fab.json"]);
    fs::remove_file(place.join("fab.json")).unwrap();

    let target = shop.path().join("target");
    fs::create_dir(&target).unwrap();
    fs::write(target.join("precious"), "x").unwrap();
    symlink(&target, place.join(STAGE)).unwrap();
    refused(whole(&place), &old(), &[STAGE]);
    assert_eq!(content(&target).len(), 1);
    fs::remove_file(place.join(STAGE)).unwrap();

    symlink(shop.path().join("nowhere"), shop.path().join("dangling")).unwrap();
    let dangling = shop.path().join("dangling");
    let failure = whole(&dangling).check(&[], &[]).unwrap_err();
    assert!(failure.to_string().contains("link to nothing"));
}

/// A disc that is full or a folder that refuses files: what was there stays.
#[test]
fn what_fails_before_all_files_are_written_changes_nothing() {
    let (shop, notes) = used();
    let place = shop.path().join("ws");
    let mut impossible = new();
    // A file can't be a folder, too.
    impossible.extend(files(&[("twice", ""), ("twice/x", "")]));
    assert!(whole(&place).write(&impossible).is_err());
    assert_written(&place, &old(), &notes, "nothing");
    let fresh = shop.path().join("fresh");
    assert!(whole(&fresh).write(&impossible).is_err());
    assert!(!fresh.exists());
}
