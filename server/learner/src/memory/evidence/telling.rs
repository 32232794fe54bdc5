//! What is foretold in a scene: by the claims about the action, by those about the primitive, or by what came of the very same context.

use std::collections::BTreeSet;

use crate::memory::evidence::columns::Column;
use crate::memory::evidence::facet::{ANYTHING, Facet, Grown, conditions, path};
use crate::memory::evidence::foretold::{Foretold, View};
use crate::memory::evidence::pool::{ALIKE_MAX, CERTAIN, Pool, is_alike};
use crate::memory::evidence::scene::{Scene, of_kind};
use crate::memory::evidence::shares::{odds, told_shares, untold};
use crate::nouns::experience::Recalled;
use crate::nouns::observation::{Observation, TypeId, Value};
use crate::nouns::vocabulary::PrimitiveId;

/// What is relied on of what the general claims, the particular ones and the memory of the very same context say, by their scores: the
/// general unless the others are certainly better. Where the context is not remembered, the particular claims say it.
pub(super) fn relied<T>(scores: [f64; 3], says: impl Fn(View) -> Option<T>) -> Option<T> {
    let [general, particular, remembered] = scores;
    let claims = [(View::General, general), (View::Particular, particular)];
    let order = if particular > general + CERTAIN { [claims[1], claims[0]] } else { claims };
    match order.into_iter().find_map(|(view, score)| Some((says(view)?, score))) {
        Some((claimed, score)) if remembered <= score + CERTAIN => Some(claimed),
        claimed => {
            let said = says(View::Remembered).or_else(|| says(View::Particular));
            said.or(claimed.map(|(claimed, _)| claimed))
        }
    }
}

impl Pool {
    /// What is foretold in a scene of the types of a facet.
    pub(super) fn foretold(&self, facet: &Facet, primitive: PrimitiveId, scene: &Scene) -> Option<Foretold> {
        let scores = facet.scores.get(&primitive).copied().unwrap_or_default();
        let foretold = relied(scores, |view| self.view(facet, view, primitive, scene))?;
        let is_exception = self.is_exception(facet, primitive, scene, &foretold);
        let remembered = is_exception.then(|| self.remembered(facet, primitive, scene)).flatten();
        Some(remembered.unwrap_or(foretold))
    }

    /// Whether the very same context is an exception that no claim tells of yet: what came of it alone makes all that came certainly more
    /// probable than what claims foretell.
    fn is_exception(&self, facet: &Facet, primitive: PrimitiveId, scene: &Scene, told: &Foretold) -> bool {
        if told.view == View::Remembered || facet.is_singly {
            return false;
        }
        let alike = self.alike.get(&primitive).and_then(|alike| alike.get(&scene.context[..]));
        let most = told.outcomes.first().and_then(|(after, _)| facet.outcomes.number(after));
        let is_as_told = |at: &usize| most.is_some() && facet.outcomes.of(*at) == most;
        if alike.is_none_or(|alike| alike.len() < 2 || alike.iter().all(is_as_told)) {
            return false;
        }
        let (by_claim, by_itself) =
            odds(&told_shares(told), untold(told), &self.alike(facet, primitive, &scene.context));
        by_itself > by_claim + CERTAIN
    }

    fn view(&self, facet: &Facet, view: View, primitive: PrimitiveId, scene: &Scene) -> Option<Foretold> {
        match (self.each_of(facet), view) {
            (_, View::Remembered) => self.remembered(facet, primitive, scene),
            (Some(each), view) => each.foretold(view, primitive, scene),
            (None, View::General) => self.claimed(facet, &facet.general, scene, view),
            (None, View::Particular) => self.claimed(facet, facet.particular.get(&primitive)?, scene, view),
        }
    }

    fn claimed(&self, facet: &Facet, grown: &Grown, scene: &Scene, view: View) -> Option<Foretold> {
        let (at, claim) = path(&grown.claim, scene);
        let conditions: Vec<_> = conditions(&grown.claim, &at).cloned().collect();
        let mut relied_on: Vec<_> =
            conditions.iter().filter_map(|condition| scene.relied_on(condition)).cloned().collect();
        if let Some((change, _)) = claim.outcomes.first() {
            relied_on.extend(scene.named_in(change));
        }
        let most = claim.outcomes.first().map(|(change, _)| (conditions, change.clone()));
        let mut outcomes: Vec<(Vec<Observation>, u32)> = Vec::new();
        for (change, count) in &claim.outcomes {
            let Some(after) = scene.after(change, &facet.kinds) else { continue };
            match outcomes.iter_mut().find(|(known, _)| *known == after) {
                Some((_, known)) => *known += count,
                None => outcomes.push((after, *count)),
            }
        }
        outcomes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let (kinds, trials) = (facet.kinds.clone(), claim.trials);
        (trials > 0).then_some(Foretold {
            kinds,
            outcomes,
            trials,
            view,
            relied_on,
            claim: most,
            attributed: true,
            is_of_each: false,
            parts: Vec::new(),
        })
    }

    /// The outcomes of a primitive in the very same context, each with how often it came to that.
    pub(super) fn alike(
        &self,
        facet: &Facet,
        primitive: PrimitiveId,
        context: &[Observation],
    ) -> Vec<(Vec<Observation>, u32)> {
        // Each by itself is told of contexts that were never met as a whole, and what is to be expected whatever is done by claims alone.
        let is_told = !facet.is_singly && (primitive != ANYTHING || facet.is_of_ends());
        let alike = self.alike.get(&primitive).filter(|_| is_told);
        let alike = alike.and_then(|alike| alike.get(context)).into_iter().flatten().copied();
        facet.outcomes.counted(alike.filter(|at| facet.sensed.contains(*at)))
    }

    /// The same in contexts of which those observations that are of `kinds` are just these. They are looked for among the experiences `met`,
    /// and so many of them tell enough.
    pub(super) fn alike_in(
        &self,
        facet: &Facet,
        met: &Column,
        context: &[Observation],
        kinds: &BTreeSet<TypeId>,
    ) -> Vec<(Vec<Observation>, u32)> {
        if facet.is_singly {
            return Vec::new();
        }
        let is_alike =
            |at: &usize| self.examples.get(*at).is_some_and(|(one, _)| is_alike(one, context, kinds));
        let told = |at: &usize| facet.sensed.contains(*at) && is_alike(at);
        facet.outcomes.counted(met.iter().take(ALIKE_MAX).filter(told))
    }

    fn remembered(&self, facet: &Facet, primitive: PrimitiveId, scene: &Scene) -> Option<Foretold> {
        let mut outcomes = self.alike(facet, primitive, &scene.context);
        let trials = outcomes.iter().map(|(_, count)| count).sum();
        outcomes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        (trials > 0).then(|| Foretold {
            kinds: facet.kinds.clone(),
            outcomes,
            trials,
            view: View::Remembered,
            relied_on: scene.context.to_vec(),
            claim: None,
            attributed: true,
            is_of_each: false,
            parts: Vec::new(),
        })
    }

    /// What is foretold of the types that are wanted.
    pub(super) fn foretell(
        &self,
        primitive: PrimitiveId,
        parameters: &[Option<Value>],
        context: &[Observation],
        recall: &dyn Fn(&Observation) -> Option<Recalled>,
        is_wanted: &dyn Fn(&[TypeId]) -> bool,
    ) -> Vec<Foretold> {
        let scene = Scene::new(context, parameters, self.effect(primitive));
        let foretell = |facet: &Facet, scene: &Scene| self.foretold(facet, primitive, scene);
        let facets = || self.all_facets().filter(|facet| is_wanted(&facet.kinds));
        let Some(key) = self.key else {
            return facets().filter_map(|facet| foretell(facet, &scene)).collect();
        };
        let blind = |facet: &&Facet| facet.kinds.contains(&key);
        let told: Vec<_> = facets().filter(blind).filter_map(|facet| foretell(facet, &scene)).collect();
        // How the body will be most likely, and what was there when it was so.
        let most = told.iter().find_map(|facet| facet.outcomes.first()).map(|(after, _)| of_kind(after, key));
        let recalled = most.and_then(|most| match most {
            [one] if of_kind(context, key).first() == Some(one) => {
                Some(Recalled { observations: context.into(), age: 0 })
            }
            [one] => recall(one),
            _ => None,
        });
        let seeing = scene.clone().recalling(recalled, key);
        let others = facets().filter(|facet| !blind(facet));
        told.into_iter().chain(others.filter_map(|facet| foretell(facet, &seeing))).collect()
    }
}
