use super::*;

const HEAD: &str = "name = \"mine\"\nafterwards = \"hold\"\n[values]\nrate = 0.0\n\
                    [[stage]]\nname = \"one\"\nlift = \"all\"\n\
                    [[stage]]\nname = \"two\"\nlift = \"all\"\n";
const TABLE: &str = "[experiment]\ntitle = \"Mine\"\nworld = \"wide\"\n";

/// What a file with these lines after [`HEAD`] gives.
fn written(lines: &str) -> Result<Design, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, format!("{HEAD}{lines}")).unwrap();
    let name = path.to_str().unwrap();
    let design = design(name).map_err(|error| error.to_string().replace(name, "mine.toml"));
    design.map(|design| Design {
        world: design.world.replace(folder.path().to_str().unwrap(), "FOLDER"),
        ..design
    })
}

#[test]
fn every_built_in_curriculum_is_a_sound_experiment_or_a_variant_of_one_but_the_free_one() {
    let all = designs().unwrap();
    for (name, _) in BUILT_IN {
        let variants = |known: &Design| known.variants.iter().any(|v| v.curriculum.as_deref() == Some(name));
        let used = all.iter().any(|known| known.name == name || variants(known));
        assert_eq!(used, name != "free", "{name}");
    }
    assert!(matches!(design("free"), Err(DesignError::NoExperiment { .. })));
}

#[test]
fn a_table_says_all_there_is_about_a_run() {
    let all = "peaks = { a = \"one\", b = { stage = \"two\", trial = 2 } }\n\
               published = { schemas_total = 227, table = \"VI-A\" }\nwhy = \"because\"\n\
               [[experiment.measure]]\nname = \"right\"\nof = \"precision\"\nstage = \"one\"\nagainst = [\"two\"]\n\
               [[experiment.variant]]\nname = \"no attention\"\nlearner = { attention = false }\n\
               values = { rate = 1.0 }\nnoise = { finger_misplaced = 0.1 }\n\
               [experiment.sweep]\nrate = [0.0, 0.5]\n";
    let experiment = written(&format!("{TABLE}{all}")).unwrap();
    let peak = |label: &str, stage: &str, trial| Peak { label: label.into(), stage: stage.into(), trial };
    assert_eq!(experiment.peaks, [peak("a", "one", None), peak("b", "two", Some(2))]);
    assert_eq!(experiment.published.unwrap().schemas_total, Some(227));
    assert_eq!(experiment.measures[0].against, ["two"]);
    let variant = &experiment.variants[0];
    assert_eq!(variant.settings(), ["learner.attention=false", "values.rate=1.0"]);
    assert_eq!(variant.noise, BTreeMap::from([("finger_misplaced".to_owned(), 0.1)]));
    assert_eq!(experiment.sweep, BTreeMap::from([("rate".to_owned(), vec![0.0, 0.5])]));
}

#[test]
fn a_world_file_is_looked_for_beside_the_curriculum() {
    assert_eq!(written(TABLE).unwrap().world, "wide");
    let own = TABLE.replace("wide", "mine-too.toml");
    assert_eq!(written(&own).unwrap().world, "FOLDER/mine-too.toml");
}

#[test]
fn a_run_may_have_another_body_and_go_on_from_what_was_learnt_before() {
    let plain = written(TABLE).unwrap();
    assert_eq!((plain.body, plain.after), (BodyKind::Sim, None));
    let after = "body = \"adept\"\nafter = { curriculum = \"exp1-s1-narrow\" }\n";
    let experiment = written(&format!("{TABLE}{after}")).unwrap();
    let earlier = Earlier { curriculum: "exp1-s1-narrow".to_owned(), body: BodyKind::Sim };
    assert_eq!((experiment.body, experiment.after), (BodyKind::Adept, Some(earlier)));
    let unknown = written(&format!("{TABLE}{}", after.replace("exp1-s1-narrow", "exp0"))).unwrap_err();
    assert!(unknown.contains("exp0") && unknown.contains("mine.toml:15:9"), "{unknown}");
    let unknown = written(&format!("{TABLE}{}", after.replace("adept", "octopus"))).unwrap_err();
    assert!(unknown.contains("octopus") && unknown.contains("sim"), "{unknown}");
}

#[test]
fn mistakes_are_located() {
    let cases = [
        ("", "mine.toml is a curriculum and no experiment", "[experiment]"),
        ("[experiment]\ntitle = \"Mine\"\n", "mine.toml:11:1:", "missing field `world`"),
        (&format!("{TABLE}wolrd = 1\n"), "mine.toml:14:1:", "unknown field `wolrd`"),
        (&format!("{TABLE}peaks = {{ a = \"three\" }}\n"), "mine.toml:14:15:", "there are: one, two"),
        (
            &format!("{TABLE}peaks = {{ a = {{ stage = \"one\", trial = 0 }} }}\n"),
            "mine.toml:14:15:",
            "counted from 1",
        ),
        (&format!("{TABLE}figure_from = \"zero\"\n"), "mine.toml:14:15:", "no stage is named"),
        (&format!("{TABLE}[experiment.sweep]\nrat = [0.1]\n"), "mine.toml:15:1:", "there are: rate"),
        (&format!("{TABLE}[experiment.sweep]\nrate = []\n"), "mine.toml:15:8:", "1 to 64 numbers"),
        (
            &format!("{TABLE}[[experiment.measure]]\nname = \"m\"\nof = \"precision\"\nstage = \"one\"\n"),
            "mine.toml:14:1:",
            "needs `stage` and `against`",
        ),
        (
            &format!("{TABLE}[[experiment.measure]]\nname = \"m\"\nof = \"value_sum\"\n"),
            "mine.toml:14:1:",
            "need `value`",
        ),
        (
            &format!("{TABLE}[[experiment.measure]]\nname = \"m\"\nof = \"actions\"\nvalue = \"reward\"\n"),
            "mine.toml:14:1:",
            "for value_sum and value_mean only",
        ),
        (
            &format!("{TABLE}[[experiment.measure]]\nname = \"m\"\nof = \"touching_share\"\n"),
            "mine.toml:14:1:",
            "needs `touching`",
        ),
        (
            &format!("{TABLE}map = {{ object = \"object\", effector = \"finger\", place = \"field\" }}\n"),
            "mine.toml:14:7:",
            "a map needs `reached`",
        ),
        (
            &format!("{TABLE}[[experiment.measure]]\nname = \"m\"\nof = \"beauty\"\n"),
            "mine.toml:16:6:",
            "unknown variant `beauty`",
        ),
        (
            &format!("{TABLE}[[experiment.variant]]\nname = \"v\"\nlearner = {{ atention = true }}\n"),
            "mine.toml:14:1:",
            "unknown field `atention`",
        ),
        (
            &format!("{TABLE}[[experiment.variant]]\nname = \"as it is\"\n"),
            "mine.toml:14:1:",
            "two variants are named",
        ),
    ];
    for (lines, place, complaint) in cases {
        let error = written(lines).unwrap_err();
        assert!(error.starts_with(place) && error.contains(complaint), "{lines}\ngave {error}");
    }
}
