//! A step in the making: effects are applied to memory as they arise, and kept in order.

use crate::memory::apply::Memory;
use crate::nouns::effect::Effect;
use crate::nouns::vocabulary::limits::SYMBOLS_MAX;

/// Memory, and the effects that changed it in this step.
pub(crate) struct Draft<'a> {
    memory: &'a mut Memory,
    effects: Vec<Effect>,
}

impl<'a> Draft<'a> {
    pub(crate) fn new(memory: &'a mut Memory) -> Self {
        Self { memory, effects: Vec::new() }
    }

    pub(crate) fn memory(&self) -> &Memory {
        self.memory
    }

    pub(crate) fn emit(&mut self, effect: Effect) {
        if let Err(error) = self.memory.apply(&effect) {
            // Effects are derived from this very memory; a mismatch is a defect of the learner.
            unreachable!("a step returned an effect that does not apply: {error}: {effect:?}");
        }
        self.effects.push(effect);
    }

    /// Takes in a symbol that may be new. When memory is full of symbols it stays unknown.
    pub(crate) fn meet_symbol(&mut self, symbol: &str) {
        let vocabulary = &self.memory.content().vocabulary;
        if vocabulary.symbol_named(symbol).is_none() && vocabulary.symbols().len() < SYMBOLS_MAX {
            self.emit(Effect::SymbolsMet(vec![symbol.to_owned()]));
        }
    }

    pub(crate) fn emit_all(&mut self, effects: impl IntoIterator<Item = Effect>) {
        effects.into_iter().for_each(|effect| self.emit(effect));
    }

    pub(crate) fn effects(self) -> Vec<Effect> {
        self.effects
    }
}
