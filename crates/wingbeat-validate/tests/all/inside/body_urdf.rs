use wingbeat_validate::body::urdf::*;

#[test]
fn the_reference_tree_has_four_links_in_two_branches() {
    let tree = reference().unwrap();
    assert_eq!(tree.links(), 4);
    let parent = |name: &str| tree.parent(tree.find(name).unwrap());
    assert_eq!((parent("hum_l"), parent("hum_r")), (None, None));
    assert_eq!(parent("rad_r"), tree.find("hum_r"));
    assert!((tree.mass() - 0.035).abs() < 1e-15);
}
