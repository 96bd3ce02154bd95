(* ---- An eigenvalue 0: sigma follows zeta, which never moves away from 0 where sigma has its sign, and so converges ---- *)

Lemma tends_same : forall f g a, (forall t, f t = g t) -> tends_to g a -> tends_to f a.
Proof. intros f g a E G eps epos; destruct (G eps epos) as [T H]; exists T; intros t; rewrite E; apply H. Qed.
Lemma tends_plus : forall f g a b, tends_to f a -> tends_to g b -> tends_to (fun t => f t + g t) (a + b).
Proof.
  intros f g a b F G eps epos; destruct (F (eps / 2)) as [T HT]; [lra|]; destruct (G (eps / 2)) as [U HU]; [lra|].
  exists (Rmax T U); intros t Ht; pose proof (Rmax_l T U); pose proof (Rmax_r T U).
  specialize (HT t ltac:(lra)); specialize (HU t ltac:(lra)); apply Rabs_def2 in HT, HU; apply Rabs_def1; lra.
Qed.
Lemma tends_scal : forall k f a, tends_to f a -> tends_to (fun t => k * f t) (k * a).
Proof.
  intros k f a F eps epos; assert (K : 0 < Rabs k + 1) by (pose proof (Rabs_pos k); lra).
  destruct (F (eps / (Rabs k + 1))) as [T HT]; [now apply Rdiv_lt_0_compat|]; exists T; intros t Ht; specialize (HT t Ht).
  rewrite <- Rmult_minus_distr_l, Rabs_mult; apply Rle_lt_trans with ((Rabs k + 1) * Rabs (f t - a)).
  - apply Rmult_le_compat_r; [apply Rabs_pos|lra].
  - apply (Rmult_lt_compat_l (Rabs k + 1)) in HT; [|exact K].
    replace ((Rabs k + 1) * (eps / (Rabs k + 1))) with eps in HT by (field; lra); exact HT.
Qed.
Lemma tends_by : forall k m f g h a b, (forall t, h t = k * f t + m * g t) -> b = k * a -> tends_to f a -> tends_to g 0 ->
  tends_to h b.
Proof.
  intros k m f g h a b E -> F G; apply (tends_same _ (fun t => k * f t + m * g t)); [exact E|].
  replace (k * a) with (k * a + m * 0) by ring; apply tends_plus; now apply tends_scal.
Qed.
Lemma rows_vanish : forall (x : R -> list R) rows, (forall row, In row rows -> tends_to (fun t => dot row (x t)) 0) ->
  forall c, tends_to (fun t => dot c (at_ rows (x t))) 0.
Proof.
  intros x; induction rows as [|row rows IH]; intros all [|a c]; simpl;
    try (intros eps epos; exists 0; intros t _; rewrite Rminus_0_r, Rabs_R0; lra).
  replace 0 with (IZR a * 0 + 0) by ring.
  apply (tends_plus (fun t => IZR a * dot row (x t)) (fun t => dot c (at_ rows (x t)))).
  - apply (tends_scal (IZR a) (fun t => dot row (x t))), all; now left.
  - apply IH; intros r I; apply all; now right.
Qed.

(* What falls wherever it is above e stays below e, or below where it was. *)
Lemma stays_below : forall f f' e s t, 0 < s -> s <= t -> (forall u, s <= u -> derivable_pt_lim f u (f' u)) ->
  (forall u, s <= u -> e < f u -> f' u <= 0) -> f s <= e -> f t <= e.
Proof.
  intros f f' e s t S ST D neg start; apply Rnot_lt_le; intro out.
  assert (C : forall u, s <= u -> continuity_pt f u).
  { intros u U; apply derivable_continuous_pt; exists (f' u); now apply D. }
  set (E := fun u => s <= u <= t /\ f u <= e).
  destruct (completeness E) as [T [above least]]; [exists t; intros u [U _]; lra|exists s; split; [lra|exact start]|].
  assert (T0 : s <= T) by (apply above; split; [lra|exact start]).
  assert (T1 : T <= t) by (apply least; intros u [U _]; lra).
  assert (low : f T <= e).
  { apply Rnot_lt_le; intro high; destruct (C T T0 (f T - e)) as [d [dpos near]]; [lra|].
    assert (T <= T - d); [|lra]; apply least; intros u [U B]; apply Rnot_lt_le; intro close_.
    assert (u <= T) by (apply above; split; assumption).
    destruct (Req_dec u T) as [->|N]; [lra|].
    assert (M : Rabs (f u - f T) < f T - e).
    { apply (near u); split; [split; [exact I|lra]|]; simpl; unfold R_dist; rewrite Rabs_left1; lra. }
    apply Rabs_def2 in M; lra. }
  assert (T < t) by (destruct T1 as [T1| ->]; [exact T1|lra]).
  assert (high : forall u, T < u <= t -> e < f u).
  { intros u U; apply Rnot_le_lt; intro B; assert (u <= T) by (apply above; split; [lra|exact B]); lra. }
  destruct (C T T0 ((f t - e))) as [d [dpos near]]; [lra|].
  set (u := T + Rmin d (t - T) / 2); assert (M1 := Rmin_l d (t - T)); assert (M2 := Rmin_r d (t - T)).
  assert (M : 0 < Rmin d (t - T)) by (apply Rmin_glb_lt; lra).
  destruct (MVT_cor2 f f' u t) as [c [K W]]; [unfold u; lra|intros; apply D; unfold u in *; lra|].
  assert (B : Rabs (f u - f T) < f t - e).
  { apply (near u); split; [split; [exact I|unfold u; lra]|]; simpl; unfold R_dist, u; rewrite Rabs_right; lra. }
  apply Rabs_def2 in B; pose proof (neg c ltac:(unfold u in *; lra) (high c ltac:(unfold u in *; lra))).
  assert (0 < t - u) by (unfold u; lra); nra.
Qed.
Lemma falls_and_settles : forall f f' e T, 0 < T -> (forall t, T <= t -> derivable_pt_lim f t (f' t)) ->
  (forall t, T <= t -> f' t <= 0) -> (forall t, T <= t -> e <= f t) -> exists c, tends_to f c.
Proof.
  intros f f' e T Tpos D neg low.
  destruct (settles (fun t => f (t + T) - e)) as [l H].
  - intros s t S ST; apply Rplus_le_compat_r; destruct ST as [ST| ->]; [|lra].
    destruct (MVT_cor2 f f' (s + T) (t + T)) as [c [E C]]; [lra|intros; apply D; lra|].
    pose proof (neg c ltac:(lra)); nra.
  - intros t Ht; pose proof (low (t + T) ltac:(lra)); lra.
  - exists (l + e); intros eps epos; destruct (H eps epos) as [U [Upos HU]]; exists (U + T); intros t Ht.
    specialize (HU (t - T) ltac:(lra)); replace (t - T + T) with t in HU by ring; apply Rabs_def1; lra.
Qed.
Lemma opposite : forall f c, tends_to (fun t => - f t) c -> tends_to f (- c).
Proof.
  intros f c H; apply (tends_same _ (fun t => -1 * - f t)); [intro; ring|].
  replace (- c) with (-1 * c) by ring; now apply (tends_scal (-1) (fun t => - f t)).
Qed.

Lemma converges : forall zeta zeta' sigma, (forall t, 0 < t -> derivable_pt_lim zeta t (zeta' t)) ->
  tends_to (fun t => sigma t - zeta t) 0 -> (forall t, 0 < t -> zeta' t * sigma t <= 0) -> exists c, tends_to zeta c.
Proof.
  assert (one : forall zeta zeta' sigma, (forall t, 0 < t -> derivable_pt_lim zeta t (zeta' t)) ->
    tends_to (fun t => sigma t - zeta t) 0 -> (forall t, 0 < t -> zeta' t * sigma t <= 0) ->
    forall eps, 0 < eps -> exists T, 0 < T /\ (forall t, T <= t -> eps < zeta t -> zeta' t <= 0) /\
      ((exists c, tends_to zeta c) \/ forall t, T <= t -> zeta t <= eps)).
  { intros zeta zeta' sigma D near turn eps epos; destruct (near eps epos) as [T0 H].
    set (T := Rmax T0 1); assert (Tpos : 1 <= T) by apply Rmax_r; assert (TT : T0 <= T) by apply Rmax_l.
    assert (neg : forall t, T <= t -> eps < zeta t -> zeta' t <= 0).
    { intros t Ht Z; specialize (H t ltac:(lra)); apply Rabs_def2 in H; pose proof (turn t ltac:(lra)) as K.
      apply Rnot_lt_le; intro P; assert (0 < sigma t) by lra; nra. }
    destruct (Classical_Prop.classic (exists s, T <= s /\ zeta s <= eps)) as [[s [S Z]]|none].
    - exists s; split; [lra|]; split; [intros t Ht; apply neg; lra|right]; intros t Ht.
      apply (stays_below zeta zeta' eps s t); [lra|lra|intros; apply D; lra|intros; apply neg; lra|exact Z].
    - assert (high : forall t, T <= t -> eps < zeta t).
      { intros t Ht; apply Rnot_le_lt; intro B; apply none; exists t; split; assumption. }
      exists T; split; [lra|]; split; [exact neg|left].
      apply (falls_and_settles zeta zeta' eps T); [lra|intros; apply D; lra|intros t Ht; now apply neg, high|].
      intros t Ht; left; now apply high. }
  intros zeta zeta' sigma D near turn; apply Classical_Prop.NNPP; intro none; apply none; exists 0; intros eps epos.
  destruct (one zeta zeta' sigma D near turn (eps / 2) ltac:(lra)) as [T [Tpos [_ [C|U]]]]; [contradiction|].
  destruct (one (fun t => - zeta t) (fun t => - zeta' t) (fun t => - sigma t)) with (eps := eps / 2) as [T' [T'pos [_ [[c C]|L]]]].
  - intros t Ht; apply (derivable_pt_lim_opp zeta); auto.
  - apply (tends_same _ (fun t => -1 * (sigma t - zeta t))); [intro; ring|].
    replace 0 with (-1 * 0) by ring; now apply (tends_scal (-1) (fun t => sigma t - zeta t)).
  - intros t Ht; pose proof (turn t Ht); lra.
  - lra.
  - exfalso; apply none; exists (- c); now apply opposite.
  - exists (Rmax T T'); intros t Ht; pose proof (Rmax_l T T'); pose proof (Rmax_r T T').
    specialize (U t ltac:(lra)); specialize (L t ltac:(lra)); rewrite Rminus_0_r; apply Rabs_def1; lra.
Qed.

(* What converges and whose derivative does has the derivative 0 in the limit. *)
Lemma comes_to_rest : forall f f' c d, (forall t, 0 < t -> derivable_pt_lim f t (f' t)) -> tends_to f c -> tends_to f' d -> d = 0.
Proof.
  assert (no : forall f f' c d, (forall t, 0 < t -> derivable_pt_lim f t (f' t)) -> tends_to f c -> tends_to f' d -> ~ 0 < d).
  { intros f f' c d D F G P; destruct (F (d / 4)) as [T HT]; [lra|]; destruct (G (d / 2)) as [U HU]; [lra|].
    set (s := Rmax (Rmax T U) 1); assert (1 <= s) by apply Rmax_r.
    assert (Rmax T U <= s) by apply Rmax_l; pose proof (Rmax_l T U); pose proof (Rmax_r T U).
    destruct (MVT_cor2 f f' s (s + 1)) as [u [E W]]; [lra|intros; apply D; lra|].
    pose proof (HT s ltac:(lra)) as A; pose proof (HT (s + 1) ltac:(lra)) as B; pose proof (HU u ltac:(lra)) as K.
    apply Rabs_def2 in A, B, K; replace (s + 1 - s) with 1 in E by ring; lra. }
  intros f f' c d D F G; destruct (Rtotal_order d 0) as [N|[E|P]]; [exfalso|exact E|exfalso; exact (no f f' c d D F G P)].
  apply (no (fun t => - f t) (fun t => - f' t) (- c) (- d)); [| | |lra].
  - intros t Ht; apply (derivable_pt_lim_opp f); auto.
  - apply opposite; apply (tends_same _ f); [intro; ring|exact F].
  - apply opposite; apply (tends_same _ f'); [intro; ring|exact G].
Qed.
Lemma continuous_limit : forall phi f c, continuity_pt phi c -> tends_to f c -> tends_to (fun t => phi (f t)) (phi c).
Proof.
  intros phi f c C F eps epos; destruct (C eps epos) as [d [dpos near]]; destruct (F d dpos) as [T H]; exists T; intros t Ht.
  destruct (Req_dec (f t) c) as [->|N]; [rewrite Rminus_eq_0, Rabs_R0; lra|].
  apply (near (f t)); split; [split; [exact I|congruence]|]; exact (H t Ht).
Qed.

(* w = phi(sigma); l is the lower end of the class. *)
Theorem converges_to_rest : forall (zeta sigma w : R -> R) l r, 0 < r ->
  (forall t, 0 < t -> derivable_pt_lim zeta t (- r * (w t - l * sigma t))) ->
  (forall t, 0 < t -> 0 <= (w t - l * sigma t) * sigma t) -> tends_to (fun t => sigma t - zeta t) 0 ->
  exists c, tends_to sigma c /\
    forall phi : R -> R, (forall t, 0 < t -> phi (sigma t) = w t) -> (forall y, continuity_pt phi y) -> phi c = l * c.
Proof.
  intros zeta sigma w l r rpos D turn near.
  destruct (converges zeta (fun t => - r * (w t - l * sigma t)) sigma D near) as [c Z].
  { intros t Ht; pose proof (turn t Ht); nra. }
  assert (S : tends_to sigma c).
  { apply (tends_by 1 1 zeta (fun t => sigma t - zeta t) sigma c c); [intro; ring|ring|exact Z|exact near]. }
  exists c; split; [exact S|]; intros phi graph C.
  assert (E : - r * (phi c - l * c) = 0); [|nra].
  assert (G : tends_to (fun t => - r * (phi (sigma t) - l * sigma t)) (- r * (phi c - l * c))).
  { apply (tends_scal (- r) (fun t => phi (sigma t) - l * sigma t)).
    apply (tends_same _ (fun t => phi (sigma t) + - l * sigma t)); [intro; ring|].
    replace (phi c - l * c) with (phi c + - l * c) by ring.
    apply tends_plus; [now apply continuous_limit|now apply tends_scal]. }
  apply (comes_to_rest zeta (fun t => - r * (phi (sigma t) - l * sigma t)) c _); [|exact Z|exact G].
  intros t Ht; rewrite graph by exact Ht; now apply D.
Qed.
