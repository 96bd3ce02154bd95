(* ---- Forms of (sigma_1, phi_1, sigma_2, ..) that are nowhere negative for all gains phi_i / sigma_i of a box ---- *)

Lemma map_repeat_zero : forall (n : nat) d, at_ (repeat [0%Z] n) [d] = repeat 0 n.
Proof.
  intros n d; induction n as [|n IH]; [reflexivity|].
  unfold at_ in *; cbn [repeat map dot]; rewrite IH; f_equal; ring.
Qed.
Lemma lcomb_same : forall a u, lcomb a (1 - a) u u = u.
Proof. induction u as [|x u IH]; simpl; [reflexivity|]; rewrite IH; f_equal; ring. Qed.
Lemma lcomb_less : forall u, lcomb 1 (-1) u u = repeat 0 (length u).
Proof. induction u as [|x u IH]; simpl; [reflexivity|]; rewrite IH; f_equal; ring. Qed.
Lemma lcomb_app : forall a b u u' v v', length u = length u' ->
  lcomb a b (u ++ v) (u' ++ v') = lcomb a b u u' ++ lcomb a b v v'.
Proof.
  intros a b; induction u as [|x u IH]; intros [|y u'] v v' E; try discriminate; [reflexivity|].
  injection E as E; cbn [app lcomb]; now rewrite IH.
Qed.

(* V on the line through u and v, whose difference is d. *)
Lemma V_lcomb : forall P a b u v, length u = length v ->
  V P (lcomb a b u v) = a * (a * V P u + b * sumprod u (map (fun r => dot r v) P))
    + b * (a * sumprod v (map (fun r => dot r u) P) + b * V P v).
Proof.
  intros P a b u v E; unfold V; rewrite sumprod_left by exact E; rewrite !sumprod_right by exact E; ring.
Qed.
Lemma V_concave : forall P t u v, length u = length v -> 0 <= t <= 1 -> 0 <= V P u -> 0 <= V P v ->
  V P (lcomb 1 (-1) v u) <= 0 -> 0 <= V P (lcomb t (1 - t) v u).
Proof.
  intros P t u v E T U W D; rewrite V_lcomb in * by congruence.
  set (x := sumprod v (map (fun r => dot r u) P)) in *; set (y := sumprod u (map (fun r => dot r v) P)) in *.
  set (p := V P v) in *; set (q := V P u) in *.
  replace (t * (t * p + (1 - t) * x) + (1 - t) * (t * y + (1 - t) * q))
    with (t * p + (1 - t) * q - t * (1 - t) * (p - x - y + q)) by ring.
  assert (0 <= t * (1 - t)) by nra; assert (0 <= t * p) by nra; assert (0 <= (1 - t) * q) by nra; nra.
Qed.

(* A gain p / q as (q, p); sigma_i = q_i s_i, phi_i = p_i s_i. *)
Definition ratio := (Z * Z)%type.
Fixpoint with_gains (fixed : list ratio) : list (list Z) :=
  match fixed with (q, p) :: r => [q] :: [p] :: map (cons 0%Z) (with_gains r) | [] => [] end.
Fixpoint within_gains (bounds : list (ratio * ratio)) (y : list R) : Prop :=
  match bounds, y with
  | ((q, p), (r, s)) :: b, x :: f :: y' =>
      (exists d, IZR p / IZR q <= d <= IZR s / IZR r /\ f = d * x) /\ within_gains b y'
  | [], [] => True
  | _, _ => False
  end.
(* At each vertex of the box, and concave in each gain. *)
Fixpoint at_vertices (Pi : list (list Z)) (fixed : list ratio) (bounds : list (ratio * ratio)) : bool :=
  match bounds with
  | [] => nonneg (length fixed) (bilinear Pi (with_gains fixed) (with_gains fixed))
  | ((q, p), (r, s)) :: b =>
      (0 <? q)%Z && (0 <? r)%Z &&
      (let own := repeat [0%Z] (2 * length fixed + 1) ++ [1%Z] :: repeat [0%Z] (2 * length b) in
       nonneg 1 (times (-1) (bilinear Pi own own))) &&
      at_vertices Pi (fixed ++ [(q, p)]) b && at_vertices Pi (fixed ++ [(r, s)]) b
  end.

Lemma at_with_gains : forall fixed q p s x, length s = length fixed ->
  at_ (with_gains (fixed ++ [(q, p)])) (s ++ [x]) = at_ (with_gains fixed) s ++ [IZR q * x; IZR p * x].
Proof.
  induction fixed as [|[q p] fixed IH]; intros q' p' [|y s] x E; try discriminate.
  - cbn [app with_gains map at_ dot]; unfold at_; cbn [map dot]; rewrite !Rplus_0_r; reflexivity.
  - injection E as E; specialize (IH q' p' s x E); unfold at_ in *; cbn [app with_gains map dot].
    rewrite !map_map; cbn [dot].
    assert (Z0 : forall (l : list (list Z)) w, map (fun f => IZR 0 * y + dot f w) l = map (fun f => dot f w) l).
    { intros l w; apply map_ext; intro f; ring. }
    rewrite !Z0, IH; reflexivity.
Qed.
Lemma with_gains_length : forall fixed s, length (at_ (with_gains fixed) s) = (2 * length fixed)%nat.
Proof.
  induction fixed as [|[q p] fixed IH]; intro s; [reflexivity|].
  specialize (IH s); unfold at_ in *; cbn [with_gains map length]; rewrite !map_length in *; lia.
Qed.
Lemma within_length : forall bounds y, within_gains bounds y -> length y = (2 * length bounds)%nat.
Proof.
  induction bounds as [|[[q p] [r s]] b IH]; intros [|x [|f y]] H; try contradiction; [reflexivity|].
  destruct H as [_ H]; cbn [length]; rewrite (IH y H); lia.
Qed.

Lemma vertices_sound : forall Pi bounds fixed s y, at_vertices Pi fixed bounds = true -> length s = length fixed ->
  within_gains bounds y -> 0 <= V Pi (at_ (with_gains fixed) s ++ y).
Proof.
  intros Pi; induction bounds as [|[[q p] [r k]] b IH]; intros fixed s y test E inside.
  - destruct y as [|]; [|contradiction]; rewrite app_nil_r; unfold V; rewrite <- value_bilinear.
    now apply (nonneg_sound (length fixed)).
  - destruct y as [|x [|f y]]; try contradiction; destruct inside as [[d [D ->]] inside].
    cbn [at_vertices] in test; rewrite !andb_true_iff, !Z.ltb_lt in test.
    destruct test as [[[[Q R_] concave] low] high]; apply IZR_lt in Q, R_.
    set (l := IZR p / IZR q) in *; set (u := IZR k / IZR r) in *; set (head := at_ (with_gains fixed) s).
    assert (L : 0 <= V Pi (head ++ x :: l * x :: y)).
    { pose proof (IH _ (s ++ [x / IZR q]) y low ltac:(rewrite !app_length; simpl; lia) inside) as H.
      rewrite at_with_gains, <- app_assoc in H by exact E; cbn [app] in H.
      replace (IZR q * (x / IZR q)) with x in H by (field; lra).
      replace (IZR p * (x / IZR q)) with (l * x) in H by (unfold l; field; lra); exact H. }
    assert (U : 0 <= V Pi (head ++ x :: u * x :: y)).
    { pose proof (IH _ (s ++ [x / IZR r]) y high ltac:(rewrite !app_length; simpl; lia) inside) as H.
      rewrite at_with_gains, <- app_assoc in H by exact E; cbn [app] in H.
      replace (IZR r * (x / IZR r)) with x in H by (field; lra).
      replace (IZR k * (x / IZR r)) with (u * x) in H by (unfold u; field; lra); exact H. }
    destruct (between_ends l u d D) as [t [T ->]].
    replace (head ++ x :: (t * u + (1 - t) * l) * x :: y)
      with (lcomb t (1 - t) (head ++ x :: u * x :: y) (head ++ x :: l * x :: y)).
    2:{ rewrite lcomb_app by reflexivity; cbn [lcomb]; rewrite !lcomb_same; f_equal; f_equal; [ring|f_equal; ring]. }
    apply V_concave; [rewrite !app_length; reflexivity|exact T|exact L|exact U|].
    pose proof (nonneg_sound 1 _ [u * x - l * x] concave eq_refl) as N.
    rewrite value_times, value_bilinear in N.
    set (own := repeat [0%Z] (2 * length fixed + 1) ++ [1%Z] :: repeat [0%Z] (2 * length b)) in *.
    replace (lcomb 1 (-1) (head ++ x :: u * x :: y) (head ++ x :: l * x :: y)) with (at_ own [u * x - l * x]).
    { unfold V; lra. }
    rewrite lcomb_app by reflexivity; cbn [lcomb]; rewrite !lcomb_less; unfold own, at_; rewrite map_app.
    cbn [map dot]; fold (at_ (repeat [0%Z] (2 * length fixed + 1)) [u * x - l * x]).
    fold (at_ (repeat [0%Z] (2 * length b)) [u * x - l * x]); rewrite !map_repeat_zero.
    rewrite repeat_app; cbn [repeat]; rewrite <- app_assoc; cbn [app].
    unfold head; rewrite with_gains_length, (within_length _ _ inside).
    f_equal; f_equal; [ring|f_equal; ring].
Qed.

(* For every sigma_i, phi_i in their sectors, each pair of rows times a whole number. *)
Lemma scaled_gain : forall q d x p X P, p = d * x -> X = q * x -> P = q * p -> P = d * X.
Proof. intros q d x p X P -> -> ->; ring. Qed.
Lemma in_block : forall Pi bounds pairs z, at_vertices Pi [] bounds = true -> within_gains bounds (at_ pairs z) ->
  0 <= value (bilinear Pi pairs pairs) z.
Proof.
  intros Pi bounds pairs z test inside; rewrite value_bilinear.
  exact (vertices_sound Pi bounds [] [] _ test eq_refl inside).
Qed.

(* ---- The same by cones: with one sign of each sigma_i, (sigma_i, phi_i) is a combination of both ends ---- *)

Definition turned (g : ratio) : ratio := let '(q, p) := g in ((- q)%Z, (- p)%Z).
Fixpoint with_ends (fixed : list (ratio * ratio)) : list (list Z) :=
  match fixed with
  | ((q, p), (r, s)) :: f => [q; r] :: [p; s] :: map (fun row => 0%Z :: 0%Z :: row) (with_ends f)
  | [] => []
  end.
Inductive orthants := Cone (t : halves) | Both (s t : orthants).
Fixpoint in_orthants (Pi : list (list Z)) (fixed bounds : list (ratio * ratio)) (t : orthants) : bool :=
  match bounds, t with
  | [], Cone t => copositive Pi (with_ends fixed) (2 * length fixed) t
  | (g, h) :: b, Both s t =>
      (0 <? fst g)%Z && (0 <? fst h)%Z && in_orthants Pi (fixed ++ [(g, h)]) b s &&
      in_orthants Pi (fixed ++ [(turned g, turned h)]) b t
  | _, _ => false
  end.

Lemma at_with_ends : forall fixed q p r k s a b, length s = (2 * length fixed)%nat ->
  at_ (with_ends (fixed ++ [((q, p), (r, k))])) (s ++ [a; b])
  = at_ (with_ends fixed) s ++ [IZR q * a + IZR r * b; IZR p * a + IZR k * b].
Proof.
  induction fixed as [|[[q p] [r k]] fixed IH]; intros q' p' r' k' s a b E.
  - destruct s; [|discriminate]; unfold at_; cbn [app with_ends map dot]; rewrite !Rplus_0_r; reflexivity.
  - destruct s as [|x [|y s]]; cbn [length] in E; try lia.
    specialize (IH q' p' r' k' s a b ltac:(lia)); unfold at_ in *; cbn [app with_ends map dot].
    rewrite !map_map; cbn [dot].
    assert (Z0 : forall (l : list (list Z)) w,
      map (fun f => IZR 0 * x + (IZR 0 * y + dot f w)) l = map (fun f => dot f w) l).
    { intros l w; apply map_ext; intro f; ring. }
    rewrite !Z0, IH; reflexivity.
Qed.
Lemma orthants_sound : forall Pi bounds t fixed s y, in_orthants Pi fixed bounds t = true ->
  length s = (2 * length fixed)%nat -> Forall (Rle 0) s -> within_gains bounds y ->
  0 <= V Pi (at_ (with_ends fixed) s ++ y).
Proof.
  intros Pi; induction bounds as [|[[q p] [r k]] b IH]; intros [t|t1 t2] fixed s y test E pos inside;
    try discriminate; cbn [in_orthants] in test.
  - destruct y as [|]; [|contradiction]; rewrite app_nil_r; now apply (copositive_sound _ _ _ _ _ test).
  - destruct y as [|x [|f y]]; try contradiction; destruct inside as [[d [D ->]] inside].
    cbn [fst turned] in test; rewrite !andb_true_iff, !Z.ltb_lt in test.
    destruct test as [[[Q R_] up] down]; apply IZR_lt in Q, R_.
    set (l := IZR p / IZR q) in *; set (u := IZR k / IZR r) in *.
    destruct (between_ends l u d D) as [w [T ->]].
    assert (ends : forall v, 0 <= v -> Forall (Rle 0) (s ++ [(1 - w) * v / IZR q; w * v / IZR r])).
    { intros v v0; apply Forall_app; split; [exact pos|].
      apply Forall_cons; [|apply Forall_cons; [|apply Forall_nil]];
        (apply Rmult_le_pos; [apply Rmult_le_pos; lra|left; apply Rinv_0_lt_compat; lra]). }
    destruct (Rle_or_lt 0 x) as [X|X].
    + pose proof (IH t1 _ (s ++ [(1 - w) * x / IZR q; w * x / IZR r]) y up
        ltac:(rewrite !app_length; simpl; lia) (ends x ltac:(lra)) inside) as H.
      rewrite at_with_ends, <- app_assoc in H by exact E; cbn [app] in H.
      replace (IZR q * ((1 - w) * x / IZR q) + IZR r * (w * x / IZR r)) with x in H by (field; lra).
      replace (IZR p * ((1 - w) * x / IZR q) + IZR k * (w * x / IZR r)) with ((w * u + (1 - w) * l) * x) in H
        by (unfold u, l; field; lra); exact H.
    + pose proof (IH t2 _ (s ++ [(1 - w) * - x / IZR q; w * - x / IZR r]) y down
        ltac:(rewrite !app_length; simpl; lia) (ends (- x) ltac:(lra)) inside) as H.
      rewrite at_with_ends, <- app_assoc in H by exact E; cbn [app] in H; rewrite !opp_IZR in H.
      replace (- IZR q * ((1 - w) * - x / IZR q) + - IZR r * (w * - x / IZR r)) with x in H by (field; lra).
      replace (- IZR p * ((1 - w) * - x / IZR q) + - IZR k * (w * - x / IZR r)) with ((w * u + (1 - w) * l) * x) in H
        by (unfold u, l; field; lra); exact H.
Qed.
Lemma in_block_by_cones : forall Pi bounds t pairs z, in_orthants Pi [] bounds t = true ->
  within_gains bounds (at_ pairs z) -> 0 <= value (bilinear Pi pairs pairs) z.
Proof.
  intros Pi bounds t pairs z test inside; rewrite value_bilinear.
  exact (orthants_sound Pi bounds t [] [] _ test eq_refl (Forall_nil _) inside).
Qed.
