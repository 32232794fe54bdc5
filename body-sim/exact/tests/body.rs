//! Every world as a body: what it declares is allowed, and what it senses is what it declared.

use pschema_exact::tables::Table;
use pschema_exact::{ExactBody, WORLDS};
use pschema_protocol::body::{Body, Outcome, Senses};

#[test]
fn every_world_is_a_body_that_the_protocol_takes() {
    for entry in WORLDS {
        let mut body = ExactBody::new("toy", entry.name, 1).unwrap();
        let description = body.describe();
        assert_eq!(description.check(), Ok(()), "{}", entry.name);
        let mut failed = 0;
        for at in 0..200 {
            let mut senses = Senses::default();
            body.sense(&mut senses);
            assert!(!senses.observations().is_empty(), "{}", entry.name);
            let action = &description.repertoire[at * 7 % description.repertoire.len()];
            failed += usize::from(body.act(action) != Outcome::Done);
        }
        // Others put things elsewhere every 4 or 20 actions, and an episode that is over is followed by the next; that action counts as failed.
        let is_as_told = match Table::names().any(|name| name == entry.name) {
            true => failed < 60,
            false => [0, 9, 40].contains(&failed),
        };
        assert!(is_as_told, "{}: {failed}", entry.name);
    }
}
