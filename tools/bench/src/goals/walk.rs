//! A walk through an environment, episode after episode.

use fastrand::Rng;
use pschema_exact::chances;
use pschema_exact::tables::Table;

pub(crate) struct Walk<'a> {
    pub(crate) table: &'a Table,
    pub(crate) state: usize,
    random: Rng,
}

impl<'a> Walk<'a> {
    /// A walk that begins where an episode does. `seed` decides all chances.
    pub(crate) fn begin(table: &'a Table, seed: u64) -> Self {
        let mut walk = Self { table, state: 0, random: chances(seed) };
        walk.again();
        walk
    }

    /// Begins the next episode.
    pub(crate) fn again(&mut self) {
        self.state = self.random.choice(&self.table.starts).copied().unwrap_or(0);
    }

    /// Carries an action out, by its place.
    pub(crate) fn act(&mut self, action: usize) {
        let next = self.table.next(self.state, action);
        if let Some(drawn) = next.and_then(|next| next.draw(&mut self.random)) {
            self.state = *drawn;
        }
    }

    pub(crate) fn is_over(&self) -> bool {
        self.table.next(self.state, 0).is_none()
    }
}
