//! Evidence in the making: the experiences of each pool, and what was found of them. Each item is checked as it is taken; at the end
//! each pool is put back as it was.

use std::collections::{BTreeMap, BTreeSet};

use pschema_learner::digest;
use pschema_learner::evidence::limits::{
    BEGINNINGS_MAX, CHANGES_MAX, DEPTH_MAX, EXAMPLES_MAX, KNOWN_MAX, RECOLLECTIONS_MAX,
};
use pschema_learner::evidence::{
    Beginnings, Evidence, Found, FoundClaim, FoundEach, FoundFacet, FoundPlace, FoundTrial, OwnEffect,
    Recollection, Recollections,
};
use pschema_learner::experience::Experience;
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::vocabulary::{BodyId, PrimitiveId, Vocabulary};

use super::claim::{
    BodyBeginnings, BodyMemory, BodyRecollection, ClaimTree, ExamplePlaces, FacetChange, FoundPool,
    PLACES_MAX, PoolEffect, PoolFacet, Singly, TreeClaim,
};
use super::item::{Item, KeptExperience, Kind};
use crate::content_error::ContentError;
use crate::extent::{Extent, STEPS_MAX, limited, within};
use crate::format::mirror::Mirror;

type Taken = Result<(), ContentError>;

/// Experiences of pools, and what was found of them.
#[derive(Debug, Default)]
pub(super) struct Finding {
    pools: BTreeMap<Option<usize>, Pool>,
    facets: Vec<Facet>,
    trees: Vec<Tree>,
    /// How many experiences each body had, and what it recalls.
    recalled: BTreeMap<BodyId, (u64, Vec<Recollection>)>,
    beginnings: BTreeMap<BodyId, Beginnings>,
}

/// A pool, and what was said of what was found of it.
#[derive(Debug, Default)]
struct Pool {
    experiences: Vec<Experience>,
    /// How many experiences there are with each primitive.
    tried: BTreeMap<PrimitiveId, usize>,
    /// The most parameters that an experience has.
    parameters: usize,
    /// How many facets were announced, and the digest of all that was found.
    announced: Option<(usize, String)>,
    key: Option<TypeId>,
    effects: Vec<OwnEffect>,
    /// How many facets there are, and the types of all of them.
    facets: usize,
    kinds: BTreeSet<TypeId>,
}

#[derive(Debug)]
struct Facet {
    pool: Option<usize>,
    found: FoundFacet,
    /// The number of the facet whose observations it tells one by one, if it does so.
    singly: Option<(usize, SinglyFound)>,
}

/// What is said of a facet that tells observations of another one by one, beside its claims.
#[derive(Debug)]
struct SinglyFound {
    from: usize,
    known: Vec<Observation>,
    trial: Option<[f64; 4]>,
}

#[derive(Debug)]
struct Tree {
    facet: usize,
    /// Its number among those of the facet.
    number: usize,
    /// How many claims were announced.
    announced: usize,
    /// How often its claims were in force, all of them together.
    trials: u64,
}

impl Finding {
    pub(super) fn experience(&mut self, extent: &Extent, kept: KeptExperience) -> Taken {
        let KeptExperience { pool, experience } = kept;
        let (pool, experience): (_, Experience) = (pool.live(), experience.live());
        extent.experience(&experience)?;
        let known = self.pools.get(&pool).map_or(0, |pool| pool.experiences.len());
        if known >= Evidence::room(&extent.vocabulary)
            || !Evidence::belongs(&extent.vocabulary, pool, &experience)
        {
            return Err(ContentError::new(
                "this experience is in a pool that is full, or that is not the one of its action",
            ));
        }
        let pool = self.pools.entry(pool).or_default();
        *pool.tried.entry(experience.primitive).or_default() += 1;
        pool.parameters = pool.parameters.max(experience.parameters.len());
        pool.experiences.push(experience);
        Ok(())
    }

    /// Takes an item of what was found.
    pub(super) fn take(&mut self, extent: &Extent, item: Item) -> Taken {
        match item {
            Item::Found(found) => self.pool(extent, found),
            Item::OwnEffect(effect) => self.effect(extent, *effect),
            Item::Facet(facet) => self.facet(extent, facet),
            Item::Change(change) => self.change(extent, *change),
            Item::Tree(tree) => self.tree(tree),
            Item::Claim(claim) => self.claim(extent, *claim),
            Item::Places(places) => self.places(places),
            Item::Recalling(BodyMemory { body, experiences }) => {
                let body = body.live();
                extent.body(body)?;
                if experiences > STEPS_MAX {
                    return Err(ContentError::value("how many experiences a body had"));
                }
                match self.recalled.insert(body, (experiences, Vec::new())) {
                    None => Ok(()),
                    Some(_) => Err(ContentError::second(Kind::Recalling.name())),
                }
            }
            Item::Recollection(one) => self.recollection(extent, *one),
            Item::Beginnings(one) => self.beginnings(extent, &one),
            // All others are taken elsewhere.
            item => Err(ContentError::second(item.kind().name())),
        }
    }

    fn beginnings(&mut self, extent: &Extent, one: &BodyBeginnings) -> Taken {
        let BodyBeginnings { body, is_next, learnable } = *one;
        let body = body.live();
        extent.body(body)?;
        let [all, count] = learnable;
        if !(0.0..=count).contains(&all) || count > BEGINNINGS_MAX {
            return Err(ContentError::value("how much was to be learnt where episodes began"));
        }
        match self.beginnings.insert(body, Beginnings { is_next, learnable: (all, count) }) {
            None => Ok(()),
            Some(_) => Err(ContentError::second(Kind::Beginnings.name())),
        }
    }

    fn recollection(&mut self, extent: &Extent, one: BodyRecollection) -> Taken {
        let BodyRecollection { body, shown, noted, there } = one;
        let one = Recollection { shown: shown.live(), noted, there: there.live() };
        let Some((experiences, known)) = self.recalled.get_mut(&body.live()) else {
            return Err(ContentError::missing(Kind::Recalling.name()));
        };
        limited("recollections", known.len() + 1, RECOLLECTIONS_MAX)?;
        if noted > *experiences || known.last().is_some_and(|last| last.shown >= one.shown) {
            return Err(ContentError::new(
                "what a body recalls is out of order, or was after all it lived through",
            ));
        }
        one.there.iter().chain([&one.shown]).try_for_each(|one| extent.observation(one))?;
        if !one.there.is_sorted_by(|a, b| a < b) {
            return Err(ContentError::new("the observations that a body recalls are out of order"));
        }
        known.push(one);
        Ok(())
    }

    fn pool(&mut self, extent: &Extent, FoundPool { pool, key, facets, digest }: FoundPool) -> Taken {
        extent.kinds(key.live().as_slice())?;
        let number: Option<usize> = pool.live();
        let Some(pool) = self.pools.get_mut(&number) else { return Err(no_pool()) };
        let facets = facets.live();
        // What is to be expected whatever is done tells of ends as well.
        limited("facets", facets, extent.vocabulary.types().len() + usize::from(number.is_none()))?;
        pool.key = key.live();
        match pool.announced.replace((facets, digest)) {
            None => Ok(()),
            Some(_) => Err(ContentError::second(Kind::Found.name())),
        }
    }

    /// The pool, if something of it was announced.
    fn announced(&mut self, pool: Option<usize>) -> Result<(&mut Pool, usize), ContentError> {
        let pool = self.pools.get_mut(&pool).ok_or_else(no_pool)?;
        let (facets, _) = pool.announced.as_ref().ok_or_else(no_pool)?;
        let facets = *facets;
        Ok((pool, facets))
    }

    fn effect(&mut self, extent: &Extent, PoolEffect { pool, effect }: PoolEffect) -> Taken {
        let effect: OwnEffect = effect.live();
        let (pool, _) = self.announced(Some(pool.live()))?;
        let Some(tried) = pool.tried.get(&effect.primitive) else { return Err(untried(effect.primitive)) };
        if pool.effects.last().is_some_and(|last| last.primitive >= effect.primitive) {
            return Err(ContentError::new("the own effects of a pool are out of order"));
        }
        if let Some((observations, tries)) = &effect.brought {
            observations.iter().try_for_each(|one| extent.observation(one))?;
            if !observations.is_sorted_by(|a, b| a < b) {
                return Err(ContentError::new("the observations of an own effect are out of order"));
            }
            limited("tries with this primitive", *tries, *tried)?;
        }
        pool.effects.push(effect);
        Ok(())
    }

    fn facet(&mut self, extent: &Extent, PoolFacet { pool, kinds, surprise, singly }: PoolFacet) -> Taken {
        if let Some(singly) = singly {
            let kinds: Vec<TypeId> = kinds.live();
            return self.singly(extent, pool.live(), &kinds, singly);
        }
        let (pool, found) = (pool.live(), FoundFacet { kinds: kinds.live(), surprise, ..Default::default() });
        let (of, announced) = self.announced(pool)?;
        within("facet", of.facets, announced)?;
        of.facets += 1;
        // Of ends it is told with what is to be expected whatever is done, and no body declares them.
        if pool.is_some() || found.kinds != [TypeId::ENDED] {
            extent.kinds(&found.kinds)?;
        }
        let new =
            found.kinds.is_sorted_by(|a, b| a < b) && found.kinds.iter().all(|kind| of.kinds.insert(*kind));
        if !new || found.kinds.is_empty() {
            return Err(ContentError::new(
                "the types of a facet are none, out of order, or of another facet",
            ));
        }
        let sound = |part: &[f64]| part.is_sorted() && part.iter().all(|number| (0.0..1e9).contains(number));
        if !surprise.chunks(2).all(sound) {
            return Err(ContentError::value("how much surprised"));
        }
        self.facets.push(Facet { pool, found, singly: None });
        Ok(())
    }

    /// A facet that tells the observations of another one by one.
    fn singly(&mut self, extent: &Extent, pool: Option<usize>, kinds: &[TypeId], singly: Singly) -> Taken {
        let Singly { facet, from, known, trial } = singly;
        let (of, known): (usize, Vec<Observation>) = (facet.live(), known.live());
        let other = self.facet_of(of)?;
        if other.singly.is_some() || other.pool != pool || other.found.kinds != kinds || kinds.len() != 1 {
            return Err(ContentError::new(
                "observations are told one by one that are not of one type of another facet",
            ));
        }
        let again = |facet: &Facet| {
            facet
                .singly
                .as_ref()
                .is_some_and(|(one, found)| *one == of && found.trial.is_some() == trial.is_some())
        };
        if self.facets.iter().any(again) {
            return Err(ContentError::second(Kind::Facet.name()));
        }
        limited("observations that are told one by one", known.len(), KNOWN_MAX)?;
        known.iter().try_for_each(|one| extent.observation(one))?;
        let ordered = known.is_sorted_by(|a, b| a < b) && known.iter().all(|one| kinds.contains(&one.kind()));
        if !ordered || known.is_empty() {
            return Err(ContentError::new(
                "the observations that are told one by one are none, or out of order",
            ));
        }
        if trial.iter().flatten().any(|score| !score.is_finite()) {
            return Err(ContentError::value("a score"));
        }
        let experiences = self.pools.get(&pool).map_or(0, |pool| pool.experiences.len());
        limited("experiences of the pool", from.live(), experiences)?;
        let found = FoundFacet { kinds: kinds.to_vec(), ..FoundFacet::default() };
        let singly = Some((of, SinglyFound { from: from.live(), known, trial }));
        self.facets.push(Facet { pool, found, singly });
        Ok(())
    }

    /// How many examples the claims of a facet can be of.
    fn examples_of(&self, facet: usize) -> usize {
        let Some(facet) = self.facets.get(facet) else { return 0 };
        match facet.singly {
            Some(_) => EXAMPLES_MAX,
            None => self.pools.get(&facet.pool).map_or(0, |pool| pool.experiences.len()),
        }
    }

    fn facet_of(&mut self, number: usize) -> Result<&mut Facet, ContentError> {
        let count = self.facets.len();
        within("facet", number, count)?;
        self.facets.get_mut(number).ok_or(ContentError::missing(Kind::Facet.name()))
    }

    fn change(&mut self, extent: &Extent, FacetChange { facet, change }: FacetChange) -> Taken {
        let change = change.live();
        let number = facet.live();
        let pool = self.facet_of(number)?.pool;
        let parameters = self.pools.get(&pool).map_or(0, |pool| pool.parameters);
        let facet = self.facet_of(number)?;
        let FoundFacet { kinds, changes, .. } = &mut facet.found;
        limited("changes of a facet", changes.len() + 1, CHANGES_MAX)?;
        for sketch in change.sketches() {
            if sketch.kind != TypeId::ENDED || !sketch.properties.is_empty() {
                extent.sketch(parameters, sketch)?;
            }
            if kinds.binary_search(&sketch.kind).is_err() {
                return Err(ContentError::new("a change of a facet is of a type that is not one of its own"));
            }
        }
        if changes.contains(&change) {
            return Err(ContentError::new("this change was there before"));
        }
        changes.push(change);
        Ok(())
    }

    fn tree(&mut self, tree: ClaimTree) -> Taken {
        let (number, announced): (usize, usize) = (tree.facet.live(), tree.claims.live());
        let found = tree.live();
        let pool = self.facet_of(number)?.pool;
        let pool = self.pools.get(&pool).ok_or_else(no_pool)?;
        let experiences = self.examples_of(number);
        if let Some(primitive) = found.primitive {
            let is_tried = pool.tried.contains_key(&primitive);
            let facet = self.facet_of(number)?;
            if !is_tried || (facet.pool.is_none() && facet.found.kinds != [TypeId::ENDED]) {
                return Err(untried(primitive));
            }
        }
        for count in [found.examples, found.exceptional, found.unforetold] {
            limited("experiences of the pool", count, experiences)?;
        }
        limited("claims of a tree", announced, experiences + 1)?;
        let finite = found.scores.iter().flatten().all(|score| score.is_finite());
        if !finite || (found.scores.is_some() && found.primitive.is_none()) {
            return Err(ContentError::value("a score"));
        }
        let facet = self.facet_of(number)?;
        let ordered = match facet.found.grown.last() {
            None => found.primitive.is_none() && announced > 0,
            Some(last) => last.primitive < found.primitive,
        };
        if !ordered {
            return Err(ContentError::new("the trees of a facet are out of order"));
        }
        facet.found.grown.push(found);
        let of_facet = facet.found.grown.len() - 1;
        self.trees.push(Tree { facet: number, number: of_facet, announced, trials: 0 });
        Ok(())
    }

    fn claim(&mut self, extent: &Extent, TreeClaim { tree, claim }: TreeClaim) -> Taken {
        let (tree, claim): (usize, FoundClaim) = (tree.live(), claim.live());
        within("tree", tree, self.trees.len())?;
        let experiences = self.trees.get(tree).map_or(0, |tree| self.examples_of(tree.facet));
        let Some(Tree { facet, number, announced, trials }) = self.trees.get_mut(tree) else {
            return Err(ContentError::missing(Kind::Tree.name()));
        };
        let Some(facet) = self.facets.get_mut(*facet) else {
            return Err(ContentError::missing(Kind::Facet.name()));
        };
        let changes = facet.found.changes.len();
        let Some(grown) = facet.found.grown.get_mut(*number) else {
            return Err(ContentError::missing(Kind::Tree.name()));
        };
        within("claim", grown.claims.len(), *announced)?;
        let deepest = grown.claims.last().map_or(0, |last| (last.depth + 1).min(DEPTH_MAX));
        limited("claims above this one", claim.depth, deepest)?;
        if (claim.depth == 0) != grown.claims.is_empty() || (claim.depth == 0) != claim.condition.is_none() {
            return Err(ContentError::new("the first claim of a tree, and no other, has no condition"));
        }
        let pool = self.pools.get(&facet.pool);
        let parameters = pool.map_or(0, |pool| pool.parameters);
        claim.condition.as_ref().map_or(Ok(()), |condition| extent.condition(parameters, condition))?;
        if !claim.gain.is_finite() {
            return Err(ContentError::value("a gain"));
        }
        outcomes(&claim, changes)?;
        *trials += u64::from(claim.trials);
        limited("experiences of the pool", usize::try_from(*trials).unwrap_or(usize::MAX), experiences)?;
        grown.claims.push(claim);
        Ok(())
    }

    fn places(&mut self, ExamplePlaces { facet, places }: ExamplePlaces) -> Taken {
        limited("places in one item", places.len(), PLACES_MAX)?;
        let places: Vec<Option<FoundPlace>> = places.live();
        let experiences = self.examples_of(facet.live());
        let found = &mut self.facet_of(facet.live())?.found;
        limited("experiences of the pool", found.places.len() + places.len(), experiences)?;
        let claims = found.grown.first().map_or(0, |grown| grown.claims.len());
        for place in places.iter().flatten() {
            within("claim", place.claim, claims)?;
            place.change.map_or(Ok(()), |change| within("change", change, found.changes.len()))?;
        }
        found.places.extend(places);
        Ok(())
    }

    /// The evidence, if all came that was announced.
    pub(super) fn end(self, vocabulary: &Vocabulary) -> Result<Evidence, ContentError> {
        let Self { pools, mut facets, trees, recalled, beginnings } = self;
        for Tree { facet, number, announced, .. } in trees {
            let grown = facets.get(facet).and_then(|facet| facet.found.grown.get(number));
            if grown.map_or(0, |grown| grown.claims.len()) != announced {
                return Err(ContentError::missing(Kind::Claim.name()));
            }
        }
        if facets.iter().any(|facet| facet.found.grown.is_empty()) {
            return Err(ContentError::missing(Kind::Tree.name()));
        }
        // Each stands behind the one that it belongs to.
        while let Some(Facet { singly: Some((of, singly)), found, .. }) =
            facets.iter().rposition(|facet| facet.singly.is_some()).map(|at| facets.remove(at))
        {
            let SinglyFound { from, known, trial } = singly;
            let each = FoundEach { from, known, facet: Box::new(found) };
            let Some(other) = facets.get_mut(of) else {
                return Err(ContentError::missing(Kind::Facet.name()));
            };
            match trial {
                Some(scores) => other.found.trial = Some(FoundTrial { each, scores }),
                None => other.found.each = Some(each),
            }
        }
        let mut of_pools: BTreeMap<Option<usize>, Vec<FoundFacet>> = BTreeMap::new();
        facets.into_iter().for_each(|facet| of_pools.entry(facet.pool).or_default().push(facet.found));
        let (mut evidence, mut digests) = (Evidence::default(), BTreeMap::new());
        for (number, pool) in pools {
            let Pool { experiences, announced, key, effects, .. } = pool;
            let Some((announced, digest)) = announced else {
                return Err(ContentError::missing(Kind::Found.name()));
            };
            let facets = of_pools.remove(&number).unwrap_or_default();
            if facets.len() != announced {
                return Err(ContentError::missing(Kind::Facet.name()));
            }
            evidence.restore(vocabulary, number, experiences, Found { key, effects, facets });
            digests.insert(number, digest);
        }
        for (body, (noted, all)) in recalled {
            evidence.recall(body, Recollections::new(noted, all));
        }
        for (body, beginnings) in beginnings {
            evidence.begin(body, beginnings);
        }
        for (number, found) in evidence.found() {
            let found = digest::found(&found);
            if let Some(written) = digests.get(&number).filter(|written| **written != found) {
                return Err(ContentError::new(format!(
                    "what was found of experiences has digest {found}, and what was written had {written}"
                )));
            }
        }
        Ok(evidence)
    }
}

/// Whether a claim's outcomes are among so many changes, each once, and not more often than the claim was in force.
fn outcomes(claim: &FoundClaim, changes: usize) -> Taken {
    let mut seen = vec![false; changes];
    let mut count = 0;
    for (change, times) in &claim.outcomes {
        within("change", *change, changes)?;
        let before = seen.get_mut(*change).is_some_and(|seen| std::mem::replace(seen, true));
        if before || *times == 0 {
            return Err(ContentError::new("a claim has an outcome twice, or one that never came"));
        }
        count += u64::from(*times);
    }
    if count <= u64::from(claim.trials) {
        return Ok(());
    }
    Err(ContentError::new(format!("something happened {count} times in {} trials", claim.trials)))
}

fn no_pool() -> ContentError {
    ContentError::new("it is of a pool that has no experiences, or of which nothing is announced")
}

fn untried(primitive: PrimitiveId) -> ContentError {
    ContentError::new(format!("it is of primitive {}, which no experience of the pool is with", primitive.0))
}
