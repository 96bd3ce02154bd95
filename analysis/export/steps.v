(* ---- The same by steps, for an eigenvalue 1 ---- *)

Lemma steps_same : forall f g a, (forall t, f t = g t) -> Un_cv g a -> Un_cv f a.
Proof. intros f g a E G eps epos; destruct (G eps epos) as [T H]; exists T; intros t; rewrite E; apply H. Qed.
Lemma steps_scal : forall k f a, Un_cv f a -> Un_cv (fun t => k * f t) (k * a).
Proof.
  intros k f a F; apply (CV_mult (fun _ => k) f k a); [|exact F].
  intros eps epos; exists 0%nat; intros; unfold R_dist; rewrite Rminus_eq_0, Rabs_R0; lra.
Qed.
Lemma steps_by : forall k m f g h a b, (forall t, h t = k * f t + m * g t) -> b = k * a -> Un_cv f a -> Un_cv g 0 -> Un_cv h b.
Proof.
  intros k m f g h a b E -> F G; apply (steps_same _ (fun t => k * f t + m * g t)); [exact E|].
  replace (k * a) with (k * a + m * 0) by ring.
  apply (CV_plus (fun t => k * f t) (fun t => m * g t)); now apply steps_scal.
Qed.
Lemma steps_vanish : forall (z : nat -> list R) now, (forall f, In f now -> Un_cv (fun t => dot f (z t)) 0) ->
  forall row, Un_cv (fun t => dot row (at_ now (z t))) 0.
Proof.
  assert (none : Un_cv (fun _ => 0) 0) by (intros eps epos; exists 0%nat; intros; unfold R_dist; rewrite Rminus_eq_0, Rabs_R0; lra).
  intros z; induction now as [|f now IH]; intros all [|a row]; simpl; try exact none; replace 0 with (IZR a * 0 + 0) by ring.
  apply (CV_plus (fun t => IZR a * dot f (z t)) (fun t => dot row (at_ now (z t)))).
  - apply steps_scal, all; now left.
  - apply IH; intros g G; apply all; now right.
Qed.

Lemma converges_by_steps : forall zeta psi sigma r, 0 < r -> (forall t : nat, zeta (S t) = zeta t - r * psi t) ->
  Un_cv psi 0 -> Un_cv (fun t => sigma t - zeta t) 0 -> (forall t, 0 <= psi t * sigma t) -> exists c, Un_cv zeta c.
Proof.
  assert (one : forall zeta psi sigma r, 0 < r -> (forall t : nat, zeta (S t) = zeta t - r * psi t) ->
    Un_cv psi 0 -> Un_cv (fun t => sigma t - zeta t) 0 -> (forall t, 0 <= psi t * sigma t) ->
    forall eps, 0 < eps -> (exists c, Un_cv zeta c) \/ exists T, forall t, (T <= t)%nat -> zeta t <= 2 * eps).
  { intros zeta psi sigma r rpos step small near turn eps epos; destruct (near eps epos) as [T0 H0].
    destruct (small (eps / r)) as [T1 H1]; [now apply Rdiv_lt_0_compat|]; set (T := (T0 + T1)%nat).
    assert (falls : forall t, (T <= t)%nat -> eps < zeta t -> zeta (S t) <= zeta t).
    { intros t Ht Z; specialize (H0 t ltac:(lia)); unfold R_dist in H0; rewrite Rminus_0_r in H0; apply Rabs_def2 in H0.
      pose proof (turn t); rewrite step; assert (0 < sigma t) by lra.
      assert (0 <= psi t) by (apply Rnot_lt_le; intro; nra); nra. }
    assert (slow : forall t, (T <= t)%nat -> zeta (S t) <= zeta t + eps).
    { intros t Ht; specialize (H1 t ltac:(lia)); unfold R_dist in H1; rewrite Rminus_0_r in H1; apply Rabs_def2 in H1.
      rewrite step; destruct H1 as [_ H1]; apply (Rmult_lt_compat_l r) in H1; [|exact rpos].
      replace (r * - (eps / r)) with (- eps) in H1 by (field; lra); lra. }
    destruct (Classical_Prop.classic (exists s, (T <= s)%nat /\ zeta s <= 2 * eps)) as [[s [S0 Z]]|none].
    - right; exists s; intros t Ht; induction Ht as [|t Ht IH]; [exact Z|].
      destruct (Rle_or_lt (zeta t) eps) as [L|L]; [pose proof (slow t ltac:(lia)); lra|].
      pose proof (falls t ltac:(lia) L); lra.
    - left; assert (high : forall t, (T <= t)%nat -> 2 * eps < zeta t).
      { intros t Ht; apply Rnot_le_lt; intro B; apply none; exists t; split; assumption. }
      destruct (decreasing_cv (fun n => zeta (n + T)%nat)) as [l lim].
      + intro n; apply (falls (n + T)%nat); [lia|]; pose proof (high (n + T)%nat ltac:(lia)); lra.
      + exists 0; intros x [n ->]; unfold opp_seq; pose proof (high (n + T)%nat ltac:(lia)); lra.
      + exists l; intros e E; destruct (lim e E) as [N HN]; exists (N + T)%nat; intros t Ht.
        specialize (HN (t - T)%nat ltac:(lia)); cbv beta in HN; replace (t - T + T)%nat with t in HN by lia; exact HN. }
  intros zeta psi sigma r rpos step small near turn; apply Classical_Prop.NNPP; intro none; apply none; exists 0; intros eps epos.
  destruct (one zeta psi sigma r rpos step small near turn (eps / 4) ltac:(lra)) as [C|[T U]]; [contradiction|].
  destruct (one (fun t => - zeta t) (fun t => - psi t) (fun t => - sigma t) r rpos) with (eps := eps / 4) as [[c C]|[T' L]].
  - intro t; rewrite step; ring.
  - apply (steps_same _ (fun t => -1 * psi t)); [intro; ring|]; replace 0 with (-1 * 0) by ring; now apply steps_scal.
  - apply (steps_same _ (fun t => -1 * (sigma t - zeta t))); [intro; ring|].
    replace 0 with (-1 * 0) by ring; now apply (steps_scal (-1) (fun t => sigma t - zeta t)).
  - intro t; pose proof (turn t); lra.
  - lra.
  - exfalso; apply none; exists (- c); apply (steps_same _ (fun t => -1 * - zeta t)); [intro; ring|].
    replace (- c) with (-1 * c) by ring; now apply (steps_scal (-1) (fun t => - zeta t)).
  - exists (T + T')%nat; intros t Ht; specialize (U t ltac:(lia)); specialize (L t ltac:(lia)).
    unfold R_dist; rewrite Rminus_0_r; apply Rabs_def1; lra.
Qed.

Theorem rests_by_steps : forall (zeta sigma w : nat -> R) l r, 0 < r ->
  (forall t, zeta (S t) = zeta t - r * (w t - l * sigma t)) -> Un_cv (fun t => w t - l * sigma t) 0 ->
  (forall t, 0 <= (w t - l * sigma t) * sigma t) -> Un_cv (fun t => sigma t - zeta t) 0 ->
  exists c, Un_cv sigma c /\
    forall phi : R -> R, (forall t, phi (sigma t) = w t) -> (forall y, continuity_pt phi y) -> phi c = l * c.
Proof.
  intros zeta sigma w l r rpos step small turn near.
  destruct (converges_by_steps zeta (fun t => w t - l * sigma t) sigma r rpos step small near turn) as [c Z].
  assert (Sg : Un_cv sigma c) by (apply (steps_by 1 1 zeta (fun t => sigma t - zeta t) sigma c c); [intro; ring|ring|exact Z|exact near]).
  exists c; split; [exact Sg|]; intros phi graph C.
  assert (P : Un_cv (fun t => phi (sigma t)) (phi c)).
  { intros eps epos; destruct (C c eps epos) as [d [dpos close_]]; destruct (Sg d dpos) as [T H]; exists T; intros t Ht.
    destruct (Req_dec (sigma t) c) as [->|N]; [unfold R_dist; rewrite Rminus_eq_0, Rabs_R0; lra|].
    apply (close_ (sigma t)); split; [split; [exact I|congruence]|]; exact (H t Ht). }
  assert (Q : Un_cv (fun t => phi (sigma t) + - l * sigma t) (phi c + - l * c)).
  { apply (CV_plus (fun t => phi (sigma t)) (fun t => - l * sigma t)); [exact P|now apply steps_scal]. }
  assert (E : phi c + - l * c = 0); [|lra].
  apply (UL_sequence (fun t => phi (sigma t) + - l * sigma t)); [exact Q|].
  apply (steps_same _ (fun t => w t - l * sigma t)); [intro t; rewrite graph; ring|exact small].
Qed.
