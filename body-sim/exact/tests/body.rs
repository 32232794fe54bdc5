//! Every world as a body: what it declares is allowed, and what it senses is what it declared.

use std::collections::BTreeSet;

use pschema_exact::tables::Table;
use pschema_exact::{ExactBody, WORLDS};
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::limits::NAME_BYTES_MAX;

#[test]
fn every_world_is_a_body_that_the_protocol_takes() {
    for entry in WORLDS {
        let mut body = ExactBody::new("toy", entry.name, 1).unwrap();
        let description = body.describe();
        assert_eq!(description.check(), Ok(()), "{}", entry.name);
        let (mut ended, mut cut) = (0, 0);
        for at in 0..200 {
            let mut senses = Senses::default();
            body.sense(&mut senses);
            assert!(!senses.observations().is_empty(), "{}", entry.name);
            let action = &description.repertoire[at * 7 % description.repertoire.len()];
            match body.act(action) {
                Outcome::Done => (),
                Outcome::EpisodeEnded => ended += 1,
                Outcome::EpisodeCut => cut += 1,
                other => panic!("{}: {other:?}", entry.name),
            }
        }
        // Others put things elsewhere every 4 or 20 actions; in the tables episodes end, and nobody else changes anything.
        let is_as_told = match Table::names().any(|name| name == entry.name) {
            true => ended < 70 && cut == 0,
            false => ended == 0 && [0, 9, 40].contains(&cut),
        };
        assert!(is_as_told, "{}: {ended} {cut}", entry.name);
    }
}

/// Two of them have the same fields and the same actions, and ice that is slippery or not.
#[test]
fn worlds_that_look_alike_say_which_they_are() {
    let kind = |world: &str| ExactBody::new("toy", world, 1).unwrap().describe().kind;
    let all: BTreeSet<_> = WORLDS.iter().map(|entry| kind(entry.name)).collect();
    assert_eq!(all.len(), WORLDS.len(), "{all:?}");
    assert!(all.contains("exact@lake-4") && all.contains("exact@lake-4-slippery"), "{all:?}");
    assert_ne!(kind("grid:slip_percent=20"), kind("grid"));
    assert_eq!(kind("grid:height=5,width=5"), kind("grid"), "its own numbers");
    // The longest numbers leave room for what a name may hold.
    for entry in WORLDS {
        let most: Vec<_> = entry.numbers.iter().map(|one| format!("{}={}", one.name, one.max)).collect();
        let world = format!("{}:{}", entry.name, most.join(","));
        assert!(kind(&world).len() <= NAME_BYTES_MAX, "{world}");
        // And the largest world is one that attaches.
        let description = ExactBody::new("toy", &world, 1).unwrap().describe();
        assert_eq!(description.check(), Ok(()), "{world}");
    }
}

/// On FrozenLake's map of 4 x 4 there is a hole below the second field.
#[test]
fn after_an_episode_that_is_over_no_action_is_carried_out_and_the_next_begins() {
    let mut body = ExactBody::new("lake", "lake-4", 1).unwrap();
    let description = body.describe();
    let [_, down, right, _] = &description.repertoire[..] else { panic!("four actions") };
    let place = |body: &mut ExactBody| {
        let mut senses = Senses::default();
        body.sense(&mut senses);
        format!("{:?}", senses.observations())
    };
    let start = place(&mut body);
    assert_eq!(body.act(right), Outcome::Done);
    assert_eq!(body.act(down), Outcome::Done);
    let hole = place(&mut body);
    assert_ne!(hole, start);
    assert_eq!(body.act(right), Outcome::EpisodeEnded);
    assert_eq!(place(&mut body), start);
    assert_eq!(body.act(right), Outcome::Done);
    assert_ne!(place(&mut body), start);
}
