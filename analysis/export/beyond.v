(* ---- Starts beyond a set: where V > L it grows, and the solution cannot tend to 0, where V = 0 ---- *)

Definition grows_in_time (n : nat) (P now next : list (list Z)) (caps : list term) (p q : Z) : bool :=
  (0 <? p)%Z && (0 <? q)%Z &&
  nonneg n (times q (bilinear P now next ++ bilinear P next now ++ caps) ++ times (- p) (bilinear P now now)).
Definition grows_by_steps (n : nat) (P now next : list (list Z)) (caps : list term) (p q : Z) : bool :=
  (0 <? p)%Z && (0 <? q)%Z &&
  nonneg n (times q (bilinear P next next ++ caps) ++ times (- (p + q)) (bilinear P now now)).

Lemma square_below : forall a x, - a <= x <= a -> x * x <= a * a.
Proof. intros; nra. Qed.
Lemma product_vanishes : forall f g, tends_to f 0 -> tends_to g 0 -> tends_to (fun t => f t * g t) 0.
Proof.
  intros f g F G eps epos; destruct (F 1 ltac:(lra)) as [T HT]; destruct (G eps epos) as [U HU]; exists (Rmax T U); intros t Ht.
  pose proof (Rmax_l T U); pose proof (Rmax_r T U); specialize (HT t ltac:(lra)); specialize (HU t ltac:(lra)).
  rewrite Rminus_0_r in *; rewrite Rabs_mult; pose proof (Rabs_pos (f t)); pose proof (Rabs_pos (g t)); nra.
Qed.
Lemma form_vanishes : forall (z : R -> list R) now xs P, (forall f, In f now -> tends_to (fun t => dot f (z t)) 0) ->
  (forall f, In f xs -> tends_to (fun t => dot f (z t)) 0) -> tends_to (fun t => value (bilinear P xs now) (z t)) 0.
Proof.
  assert (none : tends_to (fun _ => 0) 0) by (intros eps epos; exists 0; intros; rewrite Rminus_0_r, Rabs_R0; lra).
  intros z now; induction xs as [|x xs IH]; intros [|row P] A B; simpl; try exact none.
  replace 0 with (1 * 0 + 0) by ring.
  apply (tends_plus (fun t => 1 * (dot x (z t) * dot (combine_forms row now) (z t))) (fun t => value (bilinear P xs now) (z t))).
  - apply (tends_scal 1 (fun t => dot x (z t) * dot (combine_forms row now) (z t))).
    apply (product_vanishes (fun t => dot x (z t)) (fun t => dot (combine_forms row now) (z t))); [apply B; now left|].
    apply (tends_same _ (fun t => dot row (at_ now (z t)))); [intro; apply dot_combine|].
    now apply (rows_vanish z now A).
  - apply IH; [exact A|]; intros f F; apply B; now right.
Qed.
Lemma Un_cv_scal : forall k f, Un_cv f 0 -> Un_cv (fun t => k * f t) 0.
Proof.
  intros k f F; replace 0 with (k * 0) by ring; apply (CV_mult (fun _ => k) f k 0); [|exact F].
  intros eps epos; exists 0%nat; intros; unfold R_dist; rewrite Rminus_eq_0, Rabs_R0; lra.
Qed.
Lemma form_vanishes_by_steps : forall (z : nat -> list R) now xs P, (forall f, In f now -> Un_cv (fun t => dot f (z t)) 0) ->
  (forall f, In f xs -> Un_cv (fun t => dot f (z t)) 0) -> Un_cv (fun t => value (bilinear P xs now) (z t)) 0.
Proof.
  assert (none : Un_cv (fun _ => 0) 0) by (intros eps epos; exists 0%nat; intros; unfold R_dist; rewrite Rminus_eq_0, Rabs_R0; lra).
  intros z now; induction xs as [|x xs IH]; intros [|row P] A B; simpl; try exact none; replace 0 with (0 + 0) by ring.
  apply (CV_plus (fun t => 1 * (dot x (z t) * dot (combine_forms row now) (z t))) (fun t => value (bilinear P xs now) (z t))).
  - apply (Un_cv_scal 1 (fun t => dot x (z t) * dot (combine_forms row now) (z t))).
    replace 0 with (0 * 0) by ring; apply (CV_mult (fun t => dot x (z t)) (fun t => dot (combine_forms row now) (z t))).
    + apply B; now left.
    + intros eps epos; destruct (steps_vanish z now A row eps epos) as [T H]; exists T; intros t Ht; rewrite dot_combine; auto.
  - apply IH; [exact A|]; intros f F; apply B; now right.
Qed.

Theorem escapes_in_time : forall n P now next caps p q L (z : R -> list R), grows_in_time n P now next caps p q = true ->
  (forall t, length (z t) = n) -> flows z now next -> (forall f, In f now -> continuity_pt (fun t => dot f (z t)) 0) ->
  (forall t, 0 < t -> value caps (z t) <= IZR p / IZR q * L) -> 0 <= L -> L < value (bilinear P now now) (z 0) ->
  ~ (forall f, In f now -> tends_to (fun t => dot f (z t)) 0).
Proof.
  intros n P now next caps p q L z test len F C cap Lpos start all; unfold grows_in_time in test.
  rewrite !andb_true_iff, !Z.ltb_lt in test; destruct test as [[p0 q0] grows]; apply IZR_lt in p0, q0.
  set (r := IZR p / IZR q) in *; assert (rpos : 0 < r) by (apply Rdiv_lt_0_compat; assumption).
  set (v := fun t => value (bilinear P now now) (z t)).
  set (v' := fun t => value (bilinear P now next) (z t) + value (bilinear P next now) (z t)).
  assert (fast : forall t, 0 < t -> r * (v t - L) <= v' t).
  { intros t Ht; pose proof (nonneg_sound n _ (z t) grows (len t)) as G; pose proof (cap t Ht).
    rewrite !value_app, !value_times, !value_app, opp_IZR in G; fold (v t) in G; unfold v'.
    assert (E : IZR q * (r * v t) = IZR p * v t) by (unfold r; field; lra).
    apply (Rmult_le_reg_l (IZR q)); [exact q0|]; nra. }
  assert (away : forall t, 0 < t -> v 0 - L <= v t - L).
  { intros t Ht.
    set (u := fun t => - (v t - L) * exp (- r * t)).
    set (u' := fun t => - v' t * exp (- r * t) + - (v t - L) * (- r * exp (- r * t))).
    assert (De : forall s, derivable_pt_lim (fun t => exp (- r * t)) s (- r * exp (- r * s))).
    { intro s; apply exp_flow. }
    assert (down : u t <= u 0).
    { apply (falls_from u u' 0 t Ht).
      - apply (continuity_pt_mult (fun t => - (v t - L)) (fun t => exp (- r * t))).
        + apply (continuity_pt_opp (fun t => v t - L)), (continuity_pt_minus v (fun _ => L)).
          * now apply form_continuous.
          * apply continuity_pt_const; intros ? ?; reflexivity.
        + apply derivable_continuous_pt; exists (- r * exp (- r * 0)); apply De.
      - intros s [S _]; apply (derivable_pt_lim_mult (fun t => - (v t - L)) (fun t => exp (- r * t))); [|apply De].
        apply (derivable_same (fun t => - (v t - L)) _ s (- (v' s - 0))); [reflexivity|ring|].
        apply (derivable_pt_lim_opp (fun t => v t - L)), (derivable_pt_lim_minus v (fun _ => L)).
        + now apply flow_bilinear.
        + apply derivable_pt_lim_const.
      - intros s [S _]; unfold u'; pose proof (fast s S); pose proof (exp_pos (- r * s)); nra. }
    unfold u in down; rewrite Rmult_0_r, exp_0 in down.
    assert (E : exp (- r * t) <= 1) by (rewrite <- exp_0; left; apply exp_increasing; nra).
    pose proof (exp_pos (- r * t)); unfold v in *; nra. }
  destruct (form_vanishes z now now P all all (v 0 - L) ltac:(unfold v; lra)) as [T H].
  pose proof (Rmax_l T 1); pose proof (Rmax_r T 1); specialize (H (Rmax T 1) ltac:(lra)).
  rewrite Rminus_0_r in H; apply Rabs_def2 in H; pose proof (away (Rmax T 1) ltac:(lra)); unfold v in *; lra.
Qed.

Theorem escapes_by_steps : forall n P now next caps p q L (z : nat -> list R), grows_by_steps n P now next caps p q = true ->
  (forall t, length (z t) = n) -> (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, value caps (z t) <= IZR p / IZR q * L) -> 0 <= L -> L < value (bilinear P now now) (z 0%nat) ->
  ~ (forall f, In f now -> Un_cv (fun t => dot f (z t)) 0).
Proof.
  intros n P now next caps p q L z test len step cap Lpos start all; unfold grows_by_steps in test.
  rewrite !andb_true_iff, !Z.ltb_lt in test; destruct test as [[p0 q0] grows]; apply IZR_lt in p0, q0.
  set (r := IZR p / IZR q) in *; assert (rpos : 0 < r) by (apply Rdiv_lt_0_compat; assumption).
  set (v := fun t => value (bilinear P now now) (z t)).
  assert (fast : forall t, (1 + r) * (v t - L) <= v (Datatypes.S t) - L).
  { intro t; pose proof (nonneg_sound n _ (z t) grows (len t)) as G; pose proof (cap t).
    rewrite !value_app, !value_times, !value_app, opp_IZR, plus_IZR in G; fold (v t) in G.
    assert (E : value (bilinear P next next) (z t) = v (Datatypes.S t)).
    { unfold v; rewrite !value_bilinear, step; reflexivity. }
    rewrite E in G; assert (K : IZR q * (r * v t) = IZR p * v t) by (unfold r; field; lra).
    apply (Rmult_le_reg_l (IZR q)); [exact q0|]; nra. }
  assert (away : forall t, v 0%nat - L <= v t - L).
  { assert (0 < v 0%nat - L) by (unfold v; lra).
    induction t as [|t IH]; [lra|]; pose proof (fast t); nra. }
  destruct (form_vanishes_by_steps z now now P all all (v 0%nat - L) ltac:(unfold v; lra)) as [T H].
  specialize (H T (le_n _)); unfold R_dist in H; rewrite Rminus_0_r in H; apply Rabs_def2 in H.
  pose proof (away T); unfold v in *; lra.
Qed.
