//! A schema as it reads in one situation: constants only, variables replaced under a binding.

use crate::memory::content::Content;
use crate::nouns::observation::{Observation, Substitution};
use crate::nouns::parameters::Parameters;
use crate::nouns::schema::{Form, PostCondition, SchemaId};

/// Pre- and post-conditions of a schema under a binding.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Instance {
    pub(crate) pre: Vec<Observation>,
    pub(crate) post: Vec<PostCondition<Observation>>,
    /// Whether all post-conditions are predictions, as in a generalised schema: it states a law, and gains
    /// no alternative outcomes.
    law: bool,
}

impl Instance {
    /// The schema under `binding`; `None` if a variable is left unbound or there is no such schema.
    pub(crate) fn new(content: &Content, id: SchemaId, binding: &Substitution) -> Option<Self> {
        match &content.schema(id)?.form {
            Form::Concrete(concrete) => Some(Self {
                pre: concrete.pre.iter().map(|o| content.observation(*o).clone()).collect(),
                post: concrete.post.iter().map(|p| p.of(content.observation(p.what).clone())).collect(),
                law: false,
            }),
            Form::Generalised(generalised) => {
                let mut pre: Vec<_> =
                    generalised.pre.iter().map(|p| p.apply(binding)).collect::<Option<_>>()?;
                pre.sort_unstable();
                let post = generalised.post.iter().map(|p| Some(p.of(p.what.apply(binding)?)));
                Some(Self { pre, post: post.collect::<Option<_>>()?, law: true })
            }
        }
    }

    /// The post-conditions that the schema predicts.
    pub(crate) fn predicted<'a>(
        &'a self,
        parameters: &'a Parameters,
    ) -> impl Iterator<Item = &'a PostCondition<Observation>> {
        self.post.iter().filter(|post| self.predicts(post, parameters))
    }

    /// Whether the schema predicts this of its post-conditions: it held often enough, or is part of a law.
    pub(crate) fn predicts(&self, post: &PostCondition<Observation>, parameters: &Parameters) -> bool {
        self.law || parameters.predicts(post.count)
    }

    /// Whether the schema refers to `observation` as a condition, wanted or unwanted.
    pub(crate) fn mentions(&self, observation: &Observation) -> bool {
        self.pre.contains(observation) || self.post.iter().any(|post| post.what == *observation)
    }
}
