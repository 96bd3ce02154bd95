(* ---- Continuous time ---- *)

Definition tends_to (f : R -> R) (l : R) : Prop :=
  forall eps, eps > 0 -> exists T, forall t, t >= T -> Rabs (f t - l) < eps.

Lemma nonincreasing : forall f f', (forall t, 0 < t -> derivable_pt_lim f t (f' t)) ->
  (forall t, 0 < t -> f' t <= 0) -> forall s t, 0 < s -> s <= t -> f t <= f s.
Proof.
  intros f f' D neg s t Hs [Hst|<-]; [|lra].
  destruct (MVT_cor2 f f' s t Hst) as [c [E C]]; [intros; apply D; lra|].
  pose proof (neg c ltac:(lra)) as K.
  pose proof (Rmult_le_compat_r (t - s) _ _ ltac:(lra) K); lra.
Qed.

Lemma settles : forall f, (forall s t, 0 < s -> s <= t -> f t <= f s) -> (forall t, 0 < t -> 0 <= f t) ->
  exists l, forall d, 0 < d -> exists T, 0 < T /\ forall t, T <= t -> l <= f t < l + d.
Proof.
  intros f down pos; set (u := fun n => f (INR n + 1)).
  assert (later : forall n, 0 < INR n + 1) by (intro n; pose proof (pos_INR n); lra).
  assert (Du : Un_decreasing u).
  { intro n; unfold u; apply down; [apply later|]; rewrite S_INR; lra. }
  destruct (decreasing_cv u Du) as [l lim].
  { exists 0; intros x [n ->]; unfold opp_seq, u; pose proof (pos _ (later n)); lra. }
  exists l; intros d Hd; destruct (lim d Hd) as [n Hn].
  exists (INR n + 1); split; [apply later|]; intros t Ht; split.
  - assert (Hk : INR (Z.to_nat (up t)) > t).
    { destruct (archimed t) as [A _]; rewrite INR_IZR_INZ, Z2Nat.id; [exact A|].
      apply le_IZR; pose proof (later n); lra. }
    set (k := Z.to_nat (up t)) in *.
    pose proof (decreasing_ineq u l Du lim k) as A; unfold u in A.
    pose proof (down t (INR k + 1) ltac:(pose proof (later n); lra) ltac:(lra)); lra.
  - pose proof (Hn n ltac:(lia)) as A; unfold R_dist, u in A; apply Rabs_def2 in A.
    pose proof (down (INR n + 1) t (later n) Ht); lra.
Qed.

(* V >= 0 falls at least as fast as y >= 0, and y changes no faster than V: then y tends to 0. *)
Lemma attracted : forall v v' y y',
  (forall t, 0 < t -> derivable_pt_lim v t (v' t)) -> (forall t, 0 < t -> derivable_pt_lim y t (y' t)) ->
  (forall t, 0 < t -> 0 <= v t) -> (forall t, 0 < t -> 0 <= y t) ->
  (forall t, 0 < t -> v' t <= - y t) -> (forall t, 0 < t -> y' t <= - v' t) -> tends_to y 0.
Proof.
  intros v v' y y' Dv Dy vpos ypos fast slow.
  assert (vdown := nonincreasing v v' Dv ltac:(intros t Ht; pose proof (fast t Ht); pose proof (ypos t Ht); lra)).
  assert (Du : forall t, 0 < t -> derivable_pt_lim (v + y)%F t (v' t + y' t)).
  { intros t Ht; apply derivable_pt_lim_plus; auto. }
  assert (udown := nonincreasing (v + y)%F (fun t => v' t + y' t) Du
    ltac:(intros t Ht; pose proof (slow t Ht); lra)).
  destruct (settles v vdown vpos) as [l Hl].
  destruct (settles (v + y)%F udown) as [m Hm].
  { intros t Ht; unfold plus_fct; pose proof (vpos t Ht); pose proof (ypos t Ht); lra. }
  unfold plus_fct in Hm.
  destruct (Rlt_or_le 0 (m - l)) as [big|small].
  - exfalso.
    destruct (Hl ((m - l) / 2)) as [T [Tpos HT]]; [lra|].
    destruct (Hm 1) as [T' [_ HT']]; [lra|].
    set (s := Rmax T T').
    assert (Ts : T <= s) by apply Rmax_l; assert (T's : T' <= s) by apply Rmax_r.
    set (h := 2 / (m - l) * (v s + 1)).
    assert (hpos : 0 < h).
    { unfold h; apply Rmult_lt_0_compat; [apply Rdiv_lt_0_compat; lra|]; pose proof (vpos s ltac:(lra)); lra. }
    destruct (MVT_cor2 v v' s (s + h)) as [c [E C]]; [lra|intros; apply Dv; lra|].
    pose proof (HT c ltac:(lra)); pose proof (HT' c ltac:(lra)); pose proof (fast c ltac:(lra)).
    assert (v' c <= - ((m - l) / 2)) by lra.
    pose proof (vpos (s + h) ltac:(lra)).
    assert (F : v' c * h <= - (v s + 1)).
    { apply Rle_trans with (- ((m - l) / 2) * h); [nra|]; unfold h; right; field; lra. }
    replace (s + h - s) with h in E by ring; lra.
  - intros eps epos.
    destruct (Hm eps epos) as [T [_ HT]].
    destruct (Hl 1 ltac:(lra)) as [T' [T'pos HT']].
    exists (Rmax T T'); intros t Ht.
    assert (Ts : T <= Rmax T T') by apply Rmax_l; assert (T's : T' <= Rmax T T') by apply Rmax_r.
    pose proof (HT t ltac:(lra)); pose proof (HT' t ltac:(lra)); pose proof (ypos t ltac:(lra)).
    rewrite Rabs_right; lra.
Qed.

Definition flows (z : R -> list R) (fs gs : list (list Z)) : Prop :=
  Forall2 (fun f g => forall t, 0 < t -> derivable_pt_lim (fun t => dot f (z t)) t (dot g (z t))) fs gs.

Lemma flow_row : forall z fs gs row, flows z fs gs ->
  forall t, 0 < t -> derivable_pt_lim (fun t => dot row (at_ fs (z t))) t (dot row (at_ gs (z t))).
Proof.
  intros z fs gs row F; revert row; induction F as [|f g fs gs D F IH]; intros [|a row] t Ht; simpl;
    try apply derivable_pt_lim_const.
  apply (derivable_pt_lim_plus (fun t => IZR a * dot f (z t)) (fun t => dot row (at_ fs (z t)))); [|now apply IH].
  apply (derivable_pt_lim_scal (fun t => dot f (z t))); auto.
Qed.

Lemma flow_bilinear : forall P z fs gs xs ys, flows z fs gs -> flows z xs ys ->
  forall t, 0 < t -> derivable_pt_lim (fun t => value (bilinear P xs fs) (z t)) t
    (value (bilinear P xs gs) (z t) + value (bilinear P ys fs) (z t)).
Proof.
  intros P z fs gs xs ys F G; revert P; induction G as [|x y xs ys D G IH]; intros [|row P] t Ht; simpl;
    try (rewrite Rplus_0_r; apply derivable_pt_lim_const).
  rewrite !dot_combine.
  replace (1 * (dot x (z t) * dot row (at_ gs (z t))) + value (bilinear P xs gs) (z t)
     + (1 * (dot y (z t) * dot row (at_ fs (z t))) + value (bilinear P ys fs) (z t)))
    with (1 * (dot y (z t) * dot (combine_forms row fs) (z t) + dot x (z t) * dot row (at_ gs (z t)))
      + (value (bilinear P xs gs) (z t) + value (bilinear P ys fs) (z t))) by (rewrite dot_combine; ring).
  apply (derivable_pt_lim_plus (fun t => 1 * (dot x (z t) * dot (combine_forms row fs) (z t)))
    (fun t => value (bilinear P xs fs) (z t))); [|now apply IH].
  apply (derivable_pt_lim_scal (fun t => dot x (z t) * dot (combine_forms row fs) (z t))).
  apply (derivable_pt_lim_mult (fun t => dot x (z t)) (fun t => dot (combine_forms row fs) (z t))); [auto|].
  intros eps epos; destruct (flow_row z fs gs row F t Ht eps epos) as [d Hd].
  exists d; intros h; rewrite !dot_combine; auto.
Qed.

(* Linear combinations of what is differentiated. *)
Definition mixed (rows fs : list (list Z)) : list (list Z) := map (fun row => combine_forms row fs) rows.

Lemma derivable_same : forall f g t a b, (forall s, f s = g s) -> a = b -> derivable_pt_lim f t a -> derivable_pt_lim g t b.
Proof. intros f g t a b E <- D eps epos; destruct (D eps epos) as [d H]; exists d; intros h; rewrite <- !E; auto. Qed.
Lemma exp_flow : forall r t, derivable_pt_lim (fun s => exp (r * s)) t (r * exp (r * t)).
Proof.
  intros r t; apply (derivable_same (fun s => exp (r * s)) _ t (exp (r * t) * (r * 1))); [reflexivity|ring|].
  apply (derivable_pt_lim_comp (fun s => r * s) exp); [|apply derivable_pt_lim_exp].
  apply (derivable_pt_lim_scal id), derivable_pt_lim_id.
Qed.
Lemma flow_mixed : forall z fs gs rows, flows z fs gs -> flows z (mixed rows fs) (mixed rows gs).
Proof.
  intros z fs gs rows F; induction rows as [|row rows IH]; constructor; [|exact IH]; intros t Ht.
  apply (derivable_same (fun t => dot row (at_ fs (z t))) _ t (dot row (at_ gs (z t))));
    try (intros; now rewrite dot_combine); now apply flow_row.
Qed.

Lemma flow_squares : forall z fs gs, flows z fs gs ->
  forall t, 0 < t -> derivable_pt_lim (fun t => value (squares fs) (z t)) t
    (2 * sumprod (at_ fs (z t)) (at_ gs (z t))).
Proof.
  intros z fs gs F; induction F as [|f g fs gs D F IH]; intros t Ht; simpl.
  - rewrite Rmult_0_r; apply derivable_pt_lim_const.
  - replace (2 * (dot f (z t) * dot g (z t) + sumprod (at_ fs (z t)) (at_ gs (z t))))
      with (1 * (dot g (z t) * dot f (z t) + dot f (z t) * dot g (z t))
        + 2 * sumprod (at_ fs (z t)) (at_ gs (z t))) by ring.
    apply (derivable_pt_lim_plus (fun t => 1 * (dot f (z t) * dot f (z t)))
      (fun t => value (squares fs) (z t))); [|now apply IH].
    apply (derivable_pt_lim_scal (fun t => dot f (z t) * dot f (z t))).
    apply (derivable_pt_lim_mult (fun t => dot f (z t)) (fun t => dot f (z t))); auto.
Qed.
Lemma twice_product : forall z fs gs,
  2 * sumprod (at_ fs z) (at_ gs z) <= value (squares fs) z + value (squares gs) z.
Proof.
  intros z; induction fs as [|f fs IH]; intros [|g gs].
  - simpl; lra.
  - pose proof (squares_nonneg (g :: gs) z); simpl in *; lra.
  - pose proof (squares_nonneg (f :: fs) z); simpl in *; lra.
  - specialize (IH gs); simpl in *; pose proof (Rle_0_sqr (dot f z - dot g z)); unfold Rsqr in *; nra.
Qed.

(* V = x^T P x + J, where J is at least a quadratic form [low], and has the derivative [turn], one of z. *)
Definition falls_in_time (n : nat) (P fs gs rows : list (list Z)) (low turn S : list term) (N : Z) :=
  (0 <? N)%Z && nonneg n (bilinear P fs fs ++ low) &&
  nonneg n (times N (times (-1) (bilinear P fs gs ++ bilinear P gs fs) ++ times (-1) turn ++ times (-1) S)
            ++ times (-1) (squares (mixed rows fs) ++ squares (mixed rows gs))).

Lemma in_time_by : forall n P fs gs rows low turn N (z : R -> list R) (J : R -> R), 0 < N ->
  (forall w, length w = n -> 0 <= value (bilinear P fs fs ++ low) w) ->
  (forall t, length (z t) = n) -> flows z fs gs ->
  (forall t, 0 < t -> value low (z t) <= J t) ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) ->
  (forall t, 0 < t -> value (squares (mixed rows fs)) (z t) + value (squares (mixed rows gs)) (z t)
    <= - (N * (value (bilinear P fs gs) (z t) + value (bilinear P gs fs) (z t) + value turn (z t)))) ->
  forall row, In row rows -> tends_to (fun t => dot row (at_ fs (z t))) 0.
Proof.
  intros n P fs gs rows low turn N z J pos nn len F above DJ bound row Hrow.
  assert (Hf := in_map (fun row => combine_forms row fs) rows row Hrow); fold (mixed rows fs) in Hf.
  assert (G := flow_mixed z fs gs rows F).
  set (small := mixed rows fs) in *; set (small' := mixed rows gs) in *; set (f := combine_forms row fs) in *.
  set (v := fun t => N * (value (bilinear P fs fs) (z t) + J t)).
  set (v' := fun t => N * (value (bilinear P fs gs) (z t) + value (bilinear P gs fs) (z t) + value turn (z t))).
  assert (lim : tends_to (fun t => value (squares small) (z t)) 0).
  { apply (attracted v v' _ (fun t => 2 * sumprod (at_ small (z t)) (at_ small' (z t)))).
    - intros t Ht; apply (derivable_pt_lim_scal (fun t => value (bilinear P fs fs) (z t) + J t)).
      apply (derivable_pt_lim_plus (fun t => value (bilinear P fs fs) (z t)) J); auto.
      now apply flow_bilinear.
    - now apply flow_squares.
    - intros t Ht; pose proof (nn (z t) (len t)) as M; rewrite value_app in M.
      pose proof (above t Ht); unfold v; nra.
    - intros t _; apply squares_nonneg.
    - intros t Ht; pose proof (bound t Ht); pose proof (squares_nonneg small' (z t)); unfold v'; lra.
    - intros t Ht; pose proof (bound t Ht); pose proof (twice_product (z t) small small'); unfold v'; lra. }
  intros eps epos; destruct (lim (eps * eps)) as [T HT]; [nra|].
  exists T; intros t Ht; pose proof (HT t Ht) as A.
  rewrite <- dot_combine; fold f.
  rewrite Rminus_0_r in *; pose proof (squares_nonneg small (z t)) as B; rewrite Rabs_right in A by lra.
  pose proof (squares_in small f (z t) Hf).
  rewrite <- (Rabs_right eps) by lra; apply Rsqr_lt_abs_0; unfold Rsqr; lra.
Qed.

Theorem in_time : forall n P fs gs rows low turn S N (z : R -> list R) (J : R -> R),
  falls_in_time n P fs gs rows low turn S N = true ->
  (forall t, length (z t) = n) -> flows z fs gs ->
  (forall t, 0 < t -> value low (z t) <= J t) ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) ->
  (forall t, 0 < t -> 0 <= value S (z t)) ->
  forall row, In row rows -> tends_to (fun t => dot row (at_ fs (z t))) 0.
Proof.
  intros n P fs gs rows low turn S N z J check len F above DJ class.
  unfold falls_in_time in check; rewrite !andb_true_iff, Z.ltb_lt in check.
  destruct check as [[pos nn] falls]; apply IZR_lt in pos.
  assert (nn' := fun w => nonneg_sound n _ w nn).
  apply (in_time_by n P fs gs rows low turn (IZR N) z J); auto; intros t Ht.
  pose proof (nonneg_sound n _ (z t) falls (len t)) as M.
  rewrite !value_app, !value_times, !value_app, !value_times, !value_app in M.
  pose proof (class t Ht); nra.
Qed.

(* The same for each finite upper bound of a sector: k psi^2 <= psi sigma with some k > 0, psi = phi - l sigma. *)
Definition falls_for_each_bound (n : nat) (P fs gs rows : list (list Z)) (low turn : list term) (c : Z)
    (psi sigma : list Z) (N0 N1 : Z) :=
  let least := times (-1) (bilinear P fs gs ++ bilinear P gs fs) ++ times (-1) turn ++ [((- c)%Z, (psi, sigma))] in
  (0 <? c)%Z && (0 <? N0)%Z && (0 <? N1)%Z && nonneg n (bilinear P fs fs ++ low) && nonneg n least &&
  nonneg n (times N0 least ++ [(N1, (psi, psi))] ++ times (-1) (squares (mixed rows fs) ++ squares (mixed rows gs))).

Theorem in_time_for_each_bound : forall n P fs gs rows low turn c psi sigma N0 N1 (z : R -> list R) (J : R -> R) k,
  falls_for_each_bound n P fs gs rows low turn c psi sigma N0 N1 = true ->
  (forall t, length (z t) = n) -> flows z fs gs ->
  (forall t, 0 < t -> value low (z t) <= J t) ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) ->
  0 < k -> (forall t, 0 < t -> k * (dot psi (z t) * dot psi (z t)) <= dot psi (z t) * dot sigma (z t)) ->
  forall row, In row rows -> tends_to (fun t => dot row (at_ fs (z t))) 0.
Proof.
  intros n P fs gs rows low turn c psi sigma N0 N1 z J k check len F above DJ kpos class.
  unfold falls_for_each_bound in check; rewrite !andb_true_iff, !Z.ltb_lt in check.
  destruct check as [[[[[cp p0] p1] nn] least] falls]; apply IZR_lt in cp, p0, p1.
  assert (Q : 0 < IZR N1 / (IZR c * k)) by (apply Rdiv_lt_0_compat; nra).
  assert (nn' := fun w => nonneg_sound n _ w nn).
  apply (in_time_by n P fs gs rows low turn (IZR N0 + IZR N1 / (IZR c * k)) z J); auto; [lra|]; intros t Ht.
  pose proof (nonneg_sound n _ (z t) least (len t)) as L.
  pose proof (nonneg_sound n _ (z t) falls (len t)) as M.
  pose proof (class t Ht) as K.
  repeat (rewrite value_app in L || rewrite value_times in L || rewrite value_app in M || rewrite value_times in M).
  cbn [value] in L, M.
  rewrite opp_IZR in L, M.
  set (a := value (bilinear P fs gs) (z t)) in *; set (b := value (bilinear P gs fs) (z t)) in *.
  set (d := value turn (z t)) in *; set (p := dot psi (z t)) in *; set (s := dot sigma (z t)) in *.
  assert (E : IZR N1 / (IZR c * k) * (IZR c * (k * (p * p))) = IZR N1 * (p * p)) by (field; lra).
  assert (G : IZR N1 / (IZR c * k) * (IZR c * (k * (p * p))) <= IZR N1 / (IZR c * k) * - (a + b + d)).
  { apply Rmult_le_compat_l; [lra|]; nra. }
  assert (H : IZR N0 * (- (a + b + d) - IZR c * (p * s)) <= IZR N0 * - (a + b + d)).
  { apply Rmult_le_compat_l; [lra|]; assert (0 <= p * s) by nra; nra. }
  nra.
Qed.

Lemma each_bound : forall l K phi y p a b u v, l < K -> in_sector l K phi -> phi y = p -> 0 < a -> 0 < b ->
  u = a * (p - l * y) -> v = b * y -> b / (a * (K - l)) * (u * u) <= u * v.
Proof.
  intros l K phi y p a b u v lK S E A B -> ->; pose proof (sector l K phi y p S E) as H.
  assert (D : a * (K - l) <> 0) by (apply Rgt_not_eq; nra).
  apply (Rmult_le_reg_l ((K - l))); [lra|].
  replace ((K - l) * (b / (a * (K - l)) * (a * (p - l * y) * (a * (p - l * y)))))
    with (a * b * ((p - l * y) * (p - l * y))) by (field; split; nra).
  replace ((K - l) * (a * (p - l * y) * (b * y))) with (a * b * ((p - l * y) * ((K - l) * y))) by ring.
  apply Rmult_le_compat_l; nra.
Qed.

(* ---- The integral of a nonlinearity ---- *)

Definition integral_of (Phi phi : R -> R) : Prop := Phi 0 = 0 /\ forall y, derivable_pt_lim Phi y (phi y).

Lemma chain : forall (Phi phi sigma : R -> R) z fs gs row q, flows z fs gs ->
  (forall y, derivable_pt_lim Phi y (phi y)) -> (forall s, dot row (at_ fs (z s)) = q * sigma s) -> q <> 0 ->
  forall t, 0 < t -> derivable_pt_lim (fun s => Phi (sigma s)) t (phi (sigma t) * (dot row (at_ gs (z t)) / q)).
Proof.
  intros Phi phi sigma z fs gs row q F D E nz t Ht.
  apply (derivable_pt_lim_comp sigma Phi); [|apply D].
  apply (derivable_same (fun s => / q * dot row (at_ fs (z s))) _ t (/ q * dot row (at_ gs (z t)))).
  - intro s; rewrite E; field; exact nz.
  - field; exact nz.
  - apply (derivable_pt_lim_scal (fun s => dot row (at_ fs (z s)))); now apply flow_row.
Qed.

Lemma half_square : forall a y, derivable_pt_lim (fun y => a / 2 * (y * y)) y (a * y).
Proof.
  intros a y; apply (derivable_same (fun y => a / 2 * (y * y)) _ y (a / 2 * (1 * y + y * 1))); [reflexivity|field|].
  apply (derivable_pt_lim_scal (fun y => y * y)); apply (derivable_pt_lim_mult id id); apply derivable_pt_lim_id.
Qed.

Lemma primitive_above : forall (Phi phi : R -> R) l, integral_of Phi phi ->
  (forall y, l * (y * y) <= y * phi y) -> forall y, l / 2 * (y * y) <= Phi y.
Proof.
  intros Phi phi l [Z D] B y.
  set (g := fun y => Phi y - l / 2 * (y * y)).
  assert (Dg : forall c, derivable_pt_lim g c (phi c - l * c)).
  { intro c; apply (derivable_pt_lim_minus Phi (fun y => l / 2 * (y * y))); [apply D|apply half_square]. }
  assert (g0 : g 0 = 0) by (unfold g; rewrite Z; ring).
  enough (0 <= g y) by (unfold g in *; lra).
  destruct (Rtotal_order y 0) as [neg|[->|pos]]; [|lra|].
  - destruct (MVT_cor2 g _ y 0 neg (fun c _ => Dg c)) as [c [E [C C']]].
    pose proof (B c); assert (phi c - l * c <= 0) by nra; nra.
  - destruct (MVT_cor2 g _ 0 y pos (fun c _ => Dg c)) as [c [E [C C']]].
    pose proof (B c); assert (0 <= phi c - l * c) by nra; nra.
Qed.

Lemma primitive_below : forall (Phi phi : R -> R) u, integral_of Phi phi ->
  (forall y, y * phi y <= u * (y * y)) -> forall y, Phi y <= u / 2 * (y * y).
Proof.
  intros Phi phi u [Z D] B y.
  pose proof (primitive_above (fun y => - Phi y) (fun y => - phi y) (- u)) as A.
  enough (- u / 2 * (y * y) <= - Phi y) by lra.
  apply A; [split; [lra|]|intro x; pose proof (B x); lra].
  intro x; apply (derivable_pt_lim_opp Phi); apply D.
Qed.

Lemma tends_to_part : forall q f g, 1 <= q -> (forall t, g t = q * f t) -> tends_to g 0 -> tends_to f 0.
Proof.
  intros q f g Hq E G eps epos; destruct (G eps epos) as [T HT]; exists T; intros t Ht.
  pose proof (HT t Ht) as A; rewrite E, Rminus_0_r, Rabs_mult, (Rabs_right q) in A by lra.
  rewrite Rminus_0_r; pose proof (Rabs_pos (f t)); nra.
Qed.
