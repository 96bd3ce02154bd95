(* ---- V = m'P m in discrete time: products of both ends contract it, and a solution stays among the mixtures of what
   such products make of its start, whose parts are no larger than theirs ---- *)

Inductive hull (S : list R -> Prop) : list R -> Prop :=
| hull_in : forall y, S y -> hull S y
| hull_mix : forall r u v, 0 <= r <= 1 -> hull S u -> hull S v -> hull S (lcomb r (1 - r) u v).
Lemma lcomb_nth : forall a b u v i, length u = length v -> nth i (lcomb a b u v) 0 = a * nth i u 0 + b * nth i v 0.
Proof.
  intros a b; induction u as [|x u IH]; intros [|y v] [|i] E; cbn [lcomb length nth] in *; try discriminate; try ring.
  apply IH; lia.
Qed.
Lemma hull_length : forall (S : list R -> Prop) n, (forall y, S y -> length y = n) -> forall x, hull S x -> length x = n.
Proof. intros S n L x H; induction H as [y Y|r u v R _ U _ W]; [now apply L|]; now rewrite lcomb_length by congruence. Qed.
Lemma hull_image : forall (S S' : list R -> Prop) n A, (forall y, S y -> length y = n) ->
  (forall r u v, length u = n -> length v = n -> A (lcomb r (1 - r) u v) = lcomb r (1 - r) (A u) (A v)) ->
  (forall y, S y -> S' (A y)) -> forall x, hull S x -> hull S' (A x).
Proof.
  intros S S' n A L lin step x H; induction H as [y Y|r u v R U HU W HW]; [now apply hull_in, step|].
  rewrite lin by (now apply (hull_length S)); now apply hull_mix.
Qed.
Lemma between_sizes : forall x B, Rabs x <= B -> - B <= x <= B.
Proof. intros x B H; pose proof (Rle_abs x); pose proof (Rle_abs (- x)) as K; rewrite Rabs_Ropp in K; lra. Qed.
Lemma hull_part : forall (S : list R -> Prop) n i B, (forall y, S y -> length y = n /\ Rabs (nth i y 0) <= B) ->
  forall x, hull S x -> Rabs (nth i x 0) <= B.
Proof.
  intros S n i B H x X; assert (L : forall y, hull S y -> length y = n) by (apply hull_length; intros y Y; apply (H y Y)).
  induction X as [y Y|r u v R U HU W HW]; [now apply H|].
  rewrite lcomb_nth by (rewrite (L u U), (L v W); reflexivity).
  apply Rabs_le; pose proof (between_sizes _ _ HU) as [A1 A2]; pose proof (between_sizes _ _ HW) as [B1 B2].
  pose proof (Rmult_le_compat_l r _ _ ltac:(lra) A1); pose proof (Rmult_le_compat_l r _ _ ltac:(lra) A2).
  pose proof (Rmult_le_compat_l (1 - r) _ _ ltac:(lra) B1); pose proof (Rmult_le_compat_l (1 - r) _ _ ltac:(lra) B2); lra.
Qed.

Definition carried (q : Z) (rows : list (list Z)) (u : list R) : list R := map (fun row => dot row u / IZR q) rows.
Lemma carried_lcomb : forall q rows r u v, length u = length v ->
  carried q rows (lcomb r (1 - r) u v) = lcomb r (1 - r) (carried q rows u) (carried q rows v).
Proof.
  intros q rows r u v E; induction rows as [|row rows IH]; [reflexivity|]; cbn [carried map lcomb] in *.
  fold (carried q rows u) (carried q rows v) (carried q rows (lcomb r (1 - r) u v)).
  rewrite <- IH, dot_lcomb by exact E; f_equal; unfold Rdiv; ring.
Qed.

Definition contracts_at_end (n : nat) (P N_ : list (list Z)) (zero : list term) (d a b : Z) : bool :=
  positive n (times a (times (d * d) (bilinear P (places n 0 1) (places n 0 1))) ++ times (- b) (bilinear P N_ N_) ++ times b zero).
Definition powers_contract (n : nat) (P L M : list (list Z)) (zero_l zero_k : list term) (d a b K : Z) : bool :=
  (0 <? d)%Z && (0 <? K)%Z && (0 <=? a)%Z && (a <? b)%Z &&
  positive n (times K (bilinear P (places n 0 1) (places n 0 1)) ++ times (-1) (squares (places n 0 1)))
  && contracts_at_end n P L zero_l d a b && contracts_at_end n P M zero_k d a b.
Lemma nth_norm2 : forall m j, nth j m 0 * nth j m 0 <= norm2 m.
Proof.
  induction m as [|x m IH]; intros [|j]; cbn [nth norm2]; try (pose proof (Rle_0_sqr 0) as Z0; unfold Rsqr in Z0; lra).
  - pose proof (norm2_nonneg m); lra.
  - pose proof (IH j); pose proof (Rle_0_sqr x) as X; unfold Rsqr in X; lra.
Qed.
Lemma own_places : forall n w, length w = n -> at_ (places n 0 1) w = w.
Proof. intros n w E; rewrite <- (app_nil_r w) at 1; rewrite <- E, at_places_first; apply map_one. Qed.

Theorem powers_by_steps : forall n P L M zero_l zero_k d a b K es p q Al Ak N (X : nat -> list R),
  powers_contract n P L M zero_l zero_k d a b K = true -> length es = n -> (0 < p)%nat ->
  length Al = N -> length Ak = N ->
  (forall y, length y = N -> at_ L (map (fun e => mono e y) es) = map (fun e => IZR d * mono e (carried q Al y)) es) ->
  (forall y, length y = N -> at_ M (map (fun e => mono e y) es) = map (fun e => IZR d * mono e (carried q Ak y)) es) ->
  (forall y, value zero_l (map (fun e => mono e y) es) = 0 /\ value zero_k (map (fun e => mono e y) es) = 0) ->
  (forall t, length (X t) = N) ->
  (forall t, exists r, 0 <= r <= 1 /\ X (S t) = lcomb r (1 - r) (carried q Ak (X t)) (carried q Al (X t))) ->
  forall i j, (forall y, length y = N -> nth j (map (fun e => mono e y) es) 0 = nth i y 0 ^ p) ->
  Un_cv (fun t => nth i (X t) 0) 0.
Proof.
  intros n P L M zero_l zero_k d a b K es p q Al Ak N X test len pp lenl lenk isL isM zero LX step i j isj.
  unfold powers_contract in test; rewrite !andb_true_iff, !Z.ltb_lt, Z.leb_le in test.
  destruct test as [[[[[[dp Kp] ap] ab] low] fall_l] fall_k]; apply IZR_lt in dp, Kp, ab; apply IZR_le in ap.
  set (m := fun y => map (fun e => mono e y) es); set (W := fun y => V P (m y)).
  assert (lm : forall y, length (m y) = n) by (intro y; unfold m; rewrite map_length; exact len).
  assert (above : forall y, norm2 (m y) <= IZR K * W y).
  { intro y; pose proof (positive_sound n _ (m y) low (lm y)) as H.
    rewrite value_app, !value_times, value_bilinear, squares_at, !own_places in H by apply lm; unfold W, V; lra. }
  assert (Wpos : forall y, 0 <= W y).
  { intro y; apply (Rmult_le_reg_l (IZR K)); [exact Kp|]; rewrite Rmult_0_r.
    apply Rle_trans with (norm2 (m y)); [apply norm2_nonneg|apply above]. }
  assert (less : forall N_ z A, contracts_at_end n P N_ z d a b = true -> (forall y, value z (m y) = 0) ->
    (forall y, length y = N -> at_ N_ (m y) = map (fun e => IZR d * mono e (carried q A y)) es) ->
    forall y, length y = N -> IZR b * W (carried q A y) <= IZR a * W y).
  { intros N_ z A T Z0 isN y Ly; pose proof (positive_sound n _ (m y) T (lm y)) as H.
    rewrite !value_app, !value_times, !value_bilinear, !own_places, Z0, (isN y Ly) in H by apply lm.
    rewrite <- (map_map (fun e => mono e (carried q A y)) (Rmult (IZR d))) in H; fold (m (carried q A y)) in H.
    fold (V P (map (Rmult (IZR d)) (m (carried q A y)))) (V P (m y)) in H; rewrite V_scaled in H; fold (W y) (W (carried q A y)) in H.
    rewrite mult_IZR, opp_IZR in H; assert (D2 : 0 < IZR d * IZR d) by (apply Rmult_lt_0_compat; exact dp).
    apply (Rmult_le_reg_l (IZR d * IZR d)); [exact D2|]; lra. }
  set (among := fun (t : nat) y => length y = N /\ IZR b ^ t * W y <= IZR a ^ t * W (X 0%nat)).
  assert (inside : forall t, hull (among t) (X t)).
  { induction t as [|t IH]; [apply hull_in; split; [apply LX|cbn; lra]|].
    destruct (step t) as [r [R E]]; rewrite E; apply hull_mix; [exact R| |].
    all: apply (hull_image (among t) _ N); [now intros y []|intros; now apply carried_lcomb, eq_trans with N| |exact IH].
    all: intros y [Ly B]; split; [unfold carried; rewrite map_length; assumption|].
    - pose proof (less M zero_k Ak fall_k (fun y => proj2 (zero y)) isM y Ly) as H; cbn [pow].
      assert (0 <= IZR b ^ t) by (apply pow_le; lra).
      pose proof (Rmult_le_compat_l (IZR b ^ t) _ _ ltac:(assumption) H); pose proof (Rmult_le_compat_l (IZR a) _ _ ap B); lra.
    - pose proof (less L zero_l Al fall_l (fun y => proj1 (zero y)) isL y Ly) as H; cbn [pow].
      assert (0 <= IZR b ^ t) by (apply pow_le; lra).
      pose proof (Rmult_le_compat_l (IZR b ^ t) _ _ ltac:(assumption) H); pose proof (Rmult_le_compat_l (IZR a) _ _ ap B); lra. }
  intros eps epos; set (c := (eps / 2) ^ p * (eps / 2) ^ p); set (G := IZR K * W (X 0%nat) + 1).
  assert (cpos : 0 < c) by (apply Rmult_lt_0_compat; apply pow_lt; lra).
  assert (Gpos : 0 < G) by (pose proof (Rmult_le_pos _ _ (Rlt_le _ _ Kp) (Wpos (X 0%nat))); unfold G; lra).
  assert (bpos : 0 < IZR b) by lra.
  assert (small : Rabs (IZR a / IZR b) < 1).
  { unfold Rdiv; rewrite Rabs_right by (apply Rle_ge, Rmult_le_pos; [exact ap|left; now apply Rinv_0_lt_compat]).
    apply (Rmult_lt_reg_r (IZR b)); [exact bpos|]; rewrite Rmult_assoc, Rinv_l; lra. }
  destruct (pow_lt_1_zero _ small (c / G)) as [T HT]; [now apply Rdiv_lt_0_compat|].
  exists T; intros t Ht; unfold R_dist; rewrite Rminus_0_r; apply Rle_lt_trans with (eps / 2); [|lra].
  apply (hull_part (among t) N); [|apply inside]; intros y [Ly B]; split; [exact Ly|].
  specialize (HT t ltac:(lia)); apply Rabs_def2 in HT; destruct HT as [HT _].
  assert (bt : 0 < IZR b ^ t) by (apply pow_lt; exact bpos).
  assert (E : IZR a ^ t = (IZR a / IZR b) ^ t * IZR b ^ t).
  { rewrite <- Rpow_mult_distr; f_equal; field; lra. }
  assert (B' : W y <= (IZR a / IZR b) ^ t * W (X 0%nat)).
  { apply (Rmult_le_reg_l (IZR b ^ t)); [exact bt|]; rewrite E in B; lra. }
  assert (C : norm2 (m y) < c).
  { apply Rle_lt_trans with ((IZR a / IZR b) ^ t * G).
    - apply Rle_trans with (IZR K * W y); [apply above|].
      apply Rle_trans with (IZR K * ((IZR a / IZR b) ^ t * W (X 0%nat))); [apply Rmult_le_compat_l; lra|].
      assert (0 <= (IZR a / IZR b) ^ t).
      { apply pow_le; apply Rmult_le_pos; [exact ap|left; now apply Rinv_0_lt_compat]. }
      unfold G; lra.
    - apply (Rmult_lt_compat_r G) in HT; [|exact Gpos]; replace (c / G * G) with c in HT by (field; lra); exact HT. }
  apply Rnot_lt_le; intro big.
  pose proof (nth_norm2 (m y) j) as D; unfold m in D at 1 2; rewrite (isj y Ly) in D.
  pose proof (pow_incr (eps / 2) (Rabs (nth i y 0)) p ltac:(lra)) as F; rewrite RPow_abs in F.
  pose proof (Rmult_le_compat _ _ _ _ (pow_le (eps / 2) p ltac:(lra)) (pow_le (eps / 2) p ltac:(lra)) F F) as H.
  rewrite <- Rabs_mult, Rabs_right in H by (apply Rle_ge, Rle_0_sqr); unfold c in C; lra.
Qed.
